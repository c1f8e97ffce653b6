"""A finished picture against the truth of its scene: a verdict, and the likely cause of a failure.

Whoever made the picture may have followed the document line by line (`paper`), with exact intersections (`exact`), or as the
figures are made: each is a truth of its own, and the one that the picture is nearest to is held against it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.film import UNDECIDED
from raytruth.reference_tracer.tracer.render import Picture, render
from raytruth.reference_tracer.tracer.sensitivity import sensitivity

from ..verdicts.metrics import uniform_around
from ..verdicts.tolerances import REPEATED
from .causes import ENGINE, ENOUGH, Causes, Question
from .causes import found as found_causes
from .mistaken import Exhausted, Tracers
from .mistakes import CATALOGUE, filed
from .picture import FinishedPicture

PLANES = ("color", "index", "status")
SINGLE = 32  # bits: what rounding is taken to have been at worst
ALIKE = 1.05  # numbers of failing pixels whose ratio is less
PROBED = 200  # failing pixels, of which the figure's form has to show half before it is rendered
COARSE, MOST_COARSE = 1e-3, 0.02  # a picture with more pixels further off than this has not been rounded: a colour, a share


@dataclass(frozen=True)
class Form:
    """A way of reading a scene: as its text says, or as the published figure is made."""

    name: str
    scene: Scene


def forms(scene: Scene) -> list[Form]:
    """The readings of `scene` that a right picture may follow."""
    found = [Form("as the scene says", scene)]
    if scene.as_published is not None and (other := scene.figure_form()).hash != scene.hash:
        found.append(Form(f"as the figure was published ({', '.join(other.switches) or 'no switch'})", other))
    return found


@dataclass(frozen=True)
class Difference:
    """One pixel."""

    row: int
    col: int
    size: float | None  # None where the file's colour is not finite
    expected: tuple[float, ...]
    found: tuple[float | None, ...]


@dataclass(frozen=True)
class Cause:
    id: str
    sentence: str
    stage: str
    section: str
    decision: str
    amount: float | None  # found by fitting, where the mistake has a size
    share: float  # of the failing pixels that would be unexplained without it


@dataclass(frozen=True)
class Checked:
    """What a picture is, held against the truth it is nearest to."""

    verdict: str  # "pass", "acceptable", "fail"
    form: str
    method: str
    tried: tuple[tuple[str, str, int], ...]  # form, method, how many pixels differ
    width: int
    height: int
    pixels: int
    differing: int  # beyond what the file's numbers may hide
    excused: int  # of those, within what rounding may change
    undecided: int  # of those, that the truth itself leaves open
    non_finite: int
    tolerance: float
    worst: Difference | None
    told: tuple[str, ...]
    causes: tuple[Cause, ...]
    explained: int  # by the causes, of the failing pixels that were traced for it
    traced: int
    spoiled: int  # right pixels that the causes would make wrong, of `beside` that were traced
    beside: int
    note: str  # on the causes
    alternatives: tuple[str, ...]
    where: tuple[str, ...]  # what kinds of pixels fail

    @property
    def failing(self) -> int:
        return self.differing - self.excused - self.undecided

    def document(self) -> dict:
        return {**asdict(self), "failing": self.failing}


@dataclass(frozen=True)
class Held:
    """The picture against one truth; planes are (h, w)."""

    form: Form
    method: str
    truth: Picture
    wanted: np.ndarray  # (h, w, 3), as the file would have it but for rounding
    error: np.ndarray  # infinity where not finite
    tolerance: np.ndarray
    undecided: np.ndarray

    @property
    def differing(self) -> np.ndarray:
        return self.error > self.tolerance


def sized(scene: Scene, width: int, height: int) -> Scene:
    """`scene` at the picture's size. Raises InputError where a scene cannot have it."""
    if (scene.camera.width, scene.camera.height) == (width, height):
        return scene
    try:
        return scene.resized(width, height)
    except ValueError:
        raise InputError(f"a picture of {width} x {height} pixels is larger than any a scene may have") from None


def check(picture: FinishedPicture, scene: Scene, progress: Callable[[str], None] = lambda what: None,
          causes: bool = True) -> tuple[Checked, Held]:
    """The verdict on `picture`, and the truth that it was held against.

    Raises InputError where the scene cannot be rendered at the picture's size.
    """
    height, width, _ = picture.color.shape
    told = list(picture.told)
    if (scene.camera.width, scene.camera.height) != (width, height):
        told.append(f"the picture has {width} x {height} pixels, the scene {scene.camera.width} x {scene.camera.height}: "
                    "compared at the picture's size")
    if width * scene.camera.height != height * scene.camera.width:
        told.append("its sides have another ratio than the scene's: more is seen on one of them, or less")
    held, tried = _nearest(picture, [Form(f.name, sized(f.scene, width, height)) for f in forms(scene)], progress)
    differing, undecided = held.differing, held.differing & held.undecided
    finite = np.isfinite(picture.color).all(axis=-1)
    failing, excused = differing & ~undecided, np.zeros_like(differing)
    coarse = (held.error > held.tolerance + COARSE) & ~undecided
    if failing.any() and finite.all() and coarse.mean() <= MOST_COARSE:
        progress("what rounding may change")
        found = sensitivity(held.form.scene, held.method, SINGLE)
        excused = failing & (held.error <= held.tolerance + found.bound)
        failing &= ~excused
    verdict = "fail" if failing.any() else "acceptable" if differing.any() else "pass"
    if picture.levels is None and held.wanted.max() > 1 and np.nanmax(picture.color) == 1:
        told.append("no colour is above 1 although the truth has some: clipped")
    found, note, classes = None, "", ()
    if failing.any():
        classes = _classes(failing, held)
        if causes:
            progress("which mistake shows this")
            found, note = _found(held, picture, failing)
    named = found if found and found.names else None
    return Checked(
        verdict=verdict, form=held.form.name, method=held.method, tried=tried, width=width, height=height,
        pixels=width * height,
        differing=int(differing.sum()), excused=int(excused.sum()), undecided=int(undecided.sum()),
        non_finite=int((~finite).sum()), tolerance=float(np.median(held.tolerance)), worst=_worst(held, picture, failing),
        told=tuple(told), causes=_causes(named), explained=named.explained if named else 0,
        traced=found.failing if found else 0, spoiled=named.broken if named else 0, beside=named.passing if named else 0,
        note=note, alternatives=tuple(CATALOGUE[id].sentence for id in named.alternatives) if named else (),
        where=classes), held


def _nearest(picture: FinishedPicture, readings: list[Form], progress) -> tuple[Held, tuple[tuple[str, str, int], ...]]:
    """The truth that most pixels are equal to: of the text; of the figure where that explains as much of what differs from the
    text as a cause has to (ENOUGH), for a picture that has some of its switches differs from both."""
    tried: list[Held] = []
    failing = lambda h: int((h.differing & ~h.undecided).sum())

    def tries(form: Form, method: str) -> Held:
        progress(f"{form.name}, {method}")
        tried.append(_held(picture, form, method))
        return tried[-1]

    text, *others = readings
    best = tries(text, "exact")
    if best.differing.any():
        best = min((best, tries(text, "paper")), key=lambda h: (failing(h), int(h.differing.sum())))
    for form in others if failing(best) else ():
        if not _may_be(form, picture, best):
            continue
        literal = tries(form, "paper")  # as the figures were made
        if failing(literal) <= (1 - ENOUGH) * failing(best):
            best = min((literal, tries(form, "exact")), key=failing)
    # where both fail alike, the mistake is not one of the method: a port more likely has the document's own
    if failing(best):
        literal = next(h for h in tried if h.form is best.form and h.method == "paper")
        best = literal if failing(literal) <= ALIKE * failing(best) else best
    return best, tuple((h.form.name, h.method, int(h.differing.sum())) for h in tried)


def _may_be(form: Form, picture: FinishedPicture, held: Held) -> bool:
    """Whether a few of the pixels that are not as in `held` are as in `form`, traced without compiling anything. A form is
    taken where it explains ENOUGH of them: below half of the few, it does not."""
    question = _question(held, picture, held.differing & ~held.undecided)
    pixels = np.random.default_rng(0).permutation(np.flatnonzero(question.failing))[:PROBED]
    if not len(pixels):
        return True
    tracers = Tracers(form.scene, [{}], literal=True)
    try:
        color, = tracers.colors(*np.divmod(pixels, question.failing.shape[1]))
    except Exhausted:
        return True
    with np.errstate(invalid="ignore"):
        off = np.abs(filed({}, color, picture.levels) - question.shown.reshape(-1, 3)[pixels]).max(axis=-1)
    return bool((off <= question.tolerance + ENGINE).mean() >= 0.5)


def _held(picture: FinishedPicture, form: Form, method: str) -> Held:
    truth = render(form.scene, method, planes=PLANES)
    wanted = np.clip(truth.color, 0, 1) if picture.levels else truth.color
    with np.errstate(invalid="ignore"):
        error = np.abs(picture.color - wanted).max(axis=-1)
    error = np.where(np.isfinite(error), error, np.inf)
    size = 1.0 if picture.levels else np.maximum(1, np.abs(np.nan_to_num(wanted)).max(axis=-1))
    tolerance = picture.tolerance * size + REPEATED * (1 + np.abs(np.nan_to_num(wanted)).max(axis=-1))
    return Held(form, method, truth, wanted, error, tolerance, truth.status == UNDECIDED)


def _question(held: Held, picture: FinishedPicture, failing: np.ndarray) -> Question:
    # undecided pixels prove nothing about causes
    usable = ~held.undecided & np.isfinite(picture.color).all(axis=-1) & np.isfinite(held.truth.color).all(axis=-1)
    return Question(held.form.scene, picture.color, np.nan_to_num(held.truth.color), failing & usable, usable, picture.levels,
                    float(held.tolerance.max()), held.method == "paper")


def _found(held: Held, picture: FinishedPicture, failing: np.ndarray) -> tuple[Causes | None, str]:
    if not (failing & np.isfinite(picture.color).all(axis=-1)).any():
        return None, "the failing pixels are NaN or infinite"
    found = found_causes([_question(held, picture, failing)])
    if not found.failing:
        return found, f"not measurable: none of the failing pixels could be traced again ({found.left_out} tried)"
    unfinished = "" if found.finished else " with the rays that it may follow; there may be more"
    if not found.names:
        return found, f"no known mistake explains it{unfinished}"
    return found, "" if found.finished else f"the search did not end{unfinished}"


def _causes(found: Causes | None) -> tuple[Cause, ...]:
    if found is None:
        return ()
    named = []
    for id, amount in found.mistakes.items():
        m = CATALOGUE[id]
        shown = amount if m.measured else None
        named.append(Cause(id, m.sentence, m.stage, m.section, m.decision, shown, found.shares.get(id, found.share)))
    return tuple(sorted(named, key=lambda c: -c.share))


def _worst(held: Held, picture: FinishedPicture, failing: np.ndarray) -> Difference | None:
    """The pixel that is furthest off, of the failing ones if there are any."""
    error = np.where(failing, held.error, -1.0) if failing.any() else held.error
    if not held.differing.any():
        return None
    row, col = np.unravel_index(int(error.argmax()), error.shape)
    number = lambda v: float(v) if np.isfinite(v) else None
    return Difference(int(row), int(col), number(held.error[row, col]), tuple(map(float, held.wanted[row, col])),
                      tuple(map(number, picture.color[row, col])))


def _classes(failing: np.ndarray, held: Held) -> tuple[str, ...]:
    """In which kinds of pixels the failing ones lie, where most of them do: hints, where no cause is known."""
    scene, index, count = held.form.scene, held.truth.index, int(failing.sum())
    share = lambda mask: float((failing & mask).sum()) / count
    found = []
    edges = ~uniform_around(index)
    if share(edges) > 0.8 and edges.mean() < 0.6:
        found.append(f"{share(edges):.0%} of them lie on silhouettes")
    reflects = np.array([*(o.material.reflection > 0 for o in scene.objects), False])
    clear = np.array([*(o.material.transparency > 0 for o in scene.objects), False])
    for mask, what in ((clear[index], "transparent objects"), (reflects[index] & ~clear[index], "mirrors")):
        if share(mask) > 0.8 and mask.mean() < 0.8:
            found.append(f"{share(mask):.0%} of them lie on {what}")
    for k, obj in enumerate(scene.objects):
        if share(index == k) > 0.95 and (index == k).mean() < 0.9:
            found.append(f"{share(index == k):.0%} of them lie on object {k}{f', {obj.name}' if obj.name else ''}")
    if share(index < 0) > 0.95 and (index < 0).any():
        found.append(f"{share(index < 0):.0%} of them show the background")
    if failing.mean() > 0.95:
        found.append("they lie everywhere")
    return tuple(found)
