"""Asks a port every case and judges what it answers: pixel by pixel, ray by ray, against what rounding allows.

A case passes where every pixel keeps its limit; it is acceptable where some do not, but show what the reference itself
shows when its rays are moved by rounding; else the first stage that is wrong is named. The rules for how many pixels may
be acceptable are those of verdicts/judge.py: no more than are at the mercy of rounding in the reference.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from raytruth.reference_tracer.scene.model import EFFECTS
from raytruth.reference_tracer.tracer.sensitivity import PROBES

from ..verdicts.conditioning import Limits, kinds
from ..verdicts.metrics import largest_around
from ..verdicts.tolerances import REPEATED
from . import causes
from .cases import Case
from .document import CaseResult, Cause, Part
from .mistakes import CATALOGUE, possible
from .protocol import METHODS, Declaration, Question, Reply
from .session import Failure, Port
from .truth import Truths, answered, decided

FEWEST = 8  # different numbers, from which on it is no accident that all of them are short
EXPLAINED = 16  # cases of which the cause is looked for
OF_PICTURES = ("camera", "sampling", "file")  # stages that given rays do not pass
PATIENCE = 3  # failures of the process in a row, after which nothing more is asked
STAGES = {"object": ("hit", "what a ray hits first (sections 4.1, 4.2)"), "distance": ("root", "where it hits (section 4.2)"),
          "normal": ("normal", "the normal there (decision N1)"), "color": ("shading", "the colour (section 4.3)")}
EFFECT_STAGES = {"shadow": "shadow rays (section 4.3.1)", "reflection": "reflection rays (section 4.3.2)",
                 "refraction": "refraction rays and total reflection (section 4.3.3)"}


@dataclass(frozen=True, eq=False)
class Failed:
    """What a port answered wrongly."""

    case: Case
    reply: Reply


def check(port: Port, declared: Declaration, cases: Sequence[Case], truths: Truths, seconds: float,
          known: frozenset[str] = frozenset(), told: Callable[[CaseResult], None] = lambda result: None,
          kept: list[Failed] | None = None) -> list[CaseResult]:
    """The verdict on every case, in their order; `seconds` are those a case may take, `known` the ids that may fail. Wrong
    answers are added to `kept`."""
    results, failures = [], 0
    for case in cases:
        start = time.monotonic()
        if (why := case.lacks(declared)) is not None:
            result = _result(case, "skipped", why)
        elif failures >= PATIENCE:
            result = _result(case, "skipped", f"not asked: the port's process failed {PATIENCE} times in a row")
        else:
            result = asked(port, declared, case, truths, seconds, kept)
            failures = failures + 1 if result.verdict in ("crashed", "timeout", "malformed") else 0
        results.append(result.model_copy(update={"seconds": round(time.monotonic() - start, 3), "known": case.id in known}))
        told(results[-1])
    return results


def asked(port: Port, declared: Declaration, case: Case, truths: Truths, seconds: float,
          kept: list[Failed] | None = None) -> CaseResult:
    """The verdict on one case; a wrong answer is added to `kept`."""
    found = port.answer(question(case), seconds)
    if isinstance(found, Failure):
        return _result(case, found.verdict, found.message)
    if found.unsupported is not None:
        return _result(case, "skipped", f"the port says: {found.unsupported}")
    result = judged(case, found, declared.precision, truths)
    if result.verdict in ("fail", "non-finite") and kept is not None:
        kept.append(Failed(case, found))
    return result


# --- which mistakes show this ------------------------------------------------------------------------------------------------
def likely(failed: Sequence[Failed], precision: int, truths: Truths) -> list[Cause]:
    """The mistakes that together explain what a port has answered wrongly, what most hangs on first; none where no known
    ones do. It takes seconds."""
    coarse = Counter(cause for f in failed if (cause := _coarse(f.reply, precision)))
    if coarse:
        return [coarse.most_common(1)[0][0]]
    questions = [q for f in _telling(failed) for q in _questions(f, precision, truths)]
    found = causes.found(questions) if questions else None
    if not found or not found.names:
        return []
    share = lambda id: found.shares.get(id, found.share)
    return [Cause(id=id, sentence=CATALOGUE[id].sentence, share=share(id))
            for id in sorted(found.mistakes, key=share, reverse=True)]


def _telling(failed: Sequence[Failed]) -> list[Failed]:
    """EXPLAINED of them at most, on which every mistake can show if it can on any, and that are alike as little as possible."""
    shows = {f.case.id: [id for id, m in possible(f.case.scene).items() if f.case.rays is None or m.stage not in OF_PICTURES]
             for f in failed}
    left, chosen, shown = list(failed), [], Counter()
    while left and len(chosen) < EXPLAINED:
        chosen.append(max(left, key=lambda f: sum(1 / (1 + shown[id]) for id in shows[f.case.id])))
        left.remove(chosen[-1])
        shown.update(shows[chosen[-1].case.id])
    return chosen


def _questions(failed: Failed, precision: int, truths: Truths) -> Iterator[causes.Question]:
    """The colours, and what is met first, of one answer, without what hangs on rounding; each where it is wrong."""
    case, truth = failed.case, truths.planes(failed.case)
    answer = {name: array.reshape(truth[name].shape) for name, array in failed.reply.arrays.items()}
    limits = _no_less_than(truths.limits(case, precision))
    around = limits.risk if case.rays else largest_around(limits.risk)
    sure, right = decided(truth) & (around == 0), kinds(truth, answer, limits, tells_depth=False)
    made = lambda shown, wanted, within, limit, hits: causes.Question(
        case.scene, shown, wanted, usable & ~within, usable, None, float(np.median(limit[usable])),
        METHODS[case.level] == "paper", case.rays, hits)
    usable = sure & np.isfinite(answer["color"]).all(axis=-1)
    if (usable & ~right["color"][0]).any():
        yield made(answer["color"], truth["color"], right["color"][0], limits.color, False)
    if not {"index", "t", "normal"} <= set(answer):
        return
    wanted, shown = (np.where(p["index"][..., None] >= 0, np.concatenate([p["t"][..., None], p["normal"]], axis=-1), 0.0)
                     for p in (truth, answer))
    shown = causes.aligned(shown, wanted)
    usable = sure & np.isfinite(shown).all(axis=-1) & np.isfinite(wanted).all(axis=-1)
    within = right["object"][0] & (np.abs(shown - wanted)[..., 0] <= limits.t) & (
        np.linalg.norm((shown - wanted)[..., 1:], axis=-1) <= limits.normal)
    if (usable & ~within).any():
        yield made(shown, wanted, within, np.maximum(limits.t, limits.normal), True)


def _coarse(answer: Reply, precision: int) -> Cause | None:
    """What the numbers of an answer themselves tell: that they were rounded to fewer bits than a port claims."""
    color = answer.arrays["color"]
    levels = np.unique(color * 255)
    if len(levels) > FEWEST and np.abs(levels - np.round(levels)).max() < 1e-6:
        return Cause(id="eight-bits", sentence="colours were rounded to 8 bits", share=1.0)
    for array in (color, answer.arrays.get("t", color)):
        finite = np.unique(array[np.isfinite(array)])
        if precision == 64 and len(finite) > FEWEST and (finite == finite.astype(np.float32)).all():
            return Cause(id="single-precision", sentence="numbers have the 24 bits of single precision where double is claimed",
                         share=1.0)
    return None


def question(case: Case) -> Question:
    rays = None if case.rays is None else np.concatenate([case.rays.o, case.rays.d], axis=1)
    return Question(case.scene, case.level, rays)


def judged(case: Case, reply: Reply, precision: int, truths: Truths) -> CaseResult:
    """The verdict on an answer."""
    truth = truths.planes(case)
    answer = {name: array.reshape(truth[name].shape) for name, array in reply.arrays.items()}
    known = decided(truth)
    broken = known & ~np.isfinite(answer["color"]).all(axis=-1)
    if broken.any():
        where = tuple(int(k) for k in np.argwhere(broken)[0])
        return _result(case, "non-finite", f"{broken.sum()} of {broken.size} {_places(case)} have a colour that is not finite",
                       where=_named(case, where), expected=_numbers(truth["color"][where]),
                       got=_numbers(answer["color"][where]), plane="color",
                       differing=int(broken.sum()), pixels=int(broken.size))
    if _repeats(truth, answer, known):
        return _result(case, "pass", "", pixels=int(known.size), undecided=int((~known).sum()))
    return _compared(case, truth, answer, known, truths.limits(case, precision))


def _repeats(truth, answer, known) -> bool:
    """Whether all planes are what two faultless programs in double precision make of them: the common case, cheaply."""
    off = np.abs(answer["color"] - truth["color"]).max(-1) <= REPEATED
    if "index" in answer:
        off &= answer["index"] == truth["index"]
    with np.errstate(invalid="ignore"):
        if "t" in answer:
            off &= (answer["t"] == truth["t"]) | (np.abs(answer["t"] - truth["t"]) <= REPEATED)
        if "normal" in answer:
            off &= (truth["index"] < 0) | (np.abs(answer["normal"] - truth["normal"]).max(-1) <= REPEATED)
    return bool((off | ~known).all())


def _compared(case: Case, truth, answer, known, limits: Limits) -> CaseResult:
    around = (lambda plane: plane) if case.rays else largest_around
    excusable, planes = around(limits.risk) > 0, kinds(truth, answer, _no_less_than(limits), tells_depth=False)
    within = np.logical_and.reduce([w for w, _ in planes.values()])
    explained = np.logical_and.reduce([w | e for w, e in planes.values()])
    wrong, acceptable = known & ~within & ~excusable, known & ~within & excusable & explained
    unforeseen, at_risk = known & ~within & excusable & ~explained, int((limits.risk > 0).sum())
    counts = {"pixels": int(known.size), "differing": int((wrong | unforeseen).sum()), "acceptable": int(acceptable.sum()),
              "undecided": int((~known).sum())}
    if not wrong.any() and unforeseen.sum() <= at_risk // (PROBES + 1) and acceptable.sum() <= at_risk:
        verdict = "acceptable" if acceptable.any() or unforeseen.any() else "pass"
        counts |= {"differing": 0, "acceptable": int((acceptable | unforeseen).sum())}
        return _result(case, verdict, "where rounding decides" if verdict == "acceptable" else "", **counts)
    where_wrong = wrong if wrong.any() else unforeseen if unforeseen.any() else acceptable
    return _failed(case, truth, answer, limits, planes, where_wrong, counts)


def _no_less_than(limits: Limits) -> Limits:
    """Limits that no two programs in double precision are held below (REPEATED)."""
    raised = {name: np.maximum(getattr(limits, name), REPEATED) for name in ("color", "t", "normal")}
    return Limits(**{**vars(limits), **raised})


def _failed(case: Case, truth, answer, limits: Limits, planes, wrong, counts) -> CaseResult:
    kind = next((kind for kind, (within, _) in planes.items() if (wrong & ~within).any()), "color")
    plane = {"object": "index", "distance": "t"}.get(kind, kind)
    here = wrong & ~planes[kind][0]
    here = here if here.any() else wrong
    limit = None if plane == "index" else getattr(limits, plane)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        off = np.abs(answer[plane].astype(float) - truth[plane])
        off = np.nan_to_num(off.max(-1) if off.ndim == 3 else off, nan=np.inf)
        size = np.where(here, off if limit is None else off / limit, -1)
    where = tuple(int(k) for k in np.unravel_index(np.argmax(size), size.shape))
    stage, means = STAGES[kind]
    if kind == "color":
        stage, means = _effect(case, here)
    share = f"{counts['differing'] or int(wrong.sum())} of {counts['pixels']} {_places(case)} differ"
    return _result(case, "fail", f"{share}; first in {means}", stage=stage, where=_named(case, where),
                   expected=_numbers(truth[plane][where]), got=_numbers(answer[plane][where]),
                   bound=None if limit is None else float(max(limit[where], REPEATED)), plane=plane,
                   **counts)


def _effect(case: Case, wrong: np.ndarray) -> tuple[str, str]:
    """Which rays the wrong colours depend on: of the truth without one kind of them, what else changes."""
    whole, depends = answered(case).color, {}
    for effect in EFFECTS:
        rest = tuple(e for e in EFFECTS if e != effect)
        without = answered(Case(case.name, case.level, case.scene.traced_with(effects=rest), case.section, case.rays))
        depends[effect] = np.abs(without.color - whole).max(-1) > 1e-6
    on_any = np.logical_or.reduce(list(depends.values()))
    if (wrong & ~on_any).sum() > 0.5 * wrong.sum():
        return STAGES["color"]
    shares = {effect: (wrong & on).sum() / wrong.sum() - (on & ~wrong).sum() / max((~wrong).sum(), 1)
              for effect, on in depends.items()}
    best = max(shares, key=shares.get)
    return best, EFFECT_STAGES[best]


def _places(case: Case) -> str:
    return "pixels" if case.rays is None else "rays"


def _named(case: Case, where: tuple[int, ...]) -> Part:
    if case.rays is None:
        return Part(row=where[0], col=where[1])
    return Part(ray=where[1], id=case.ids[where[1]] if case.ids else None)


def _numbers(value) -> list[float]:
    return [float(v) for v in np.atleast_1d(value)]


def _result(case: Case, verdict: str, message: str, **rest) -> CaseResult:
    return CaseResult(id=case.id, section=case.section, verdict=verdict, message=message, **rest)
