"""Two pictures at hand, held against each other by the measures, limits and judge of the suites."""

from __future__ import annotations

import tempfile
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.film import PLANES
from raytruth.reference_tracer.tracer.render import Picture

from ..execution.store import Store
from ..results import OF_OBJECTS, Gate, Run, Verdict
from . import conditioning, metrics, oracle
from .judge import judge, literal
from .measure import measured
from .tolerances import accuracy_of, between, concluded, tolerance_of, unmeasured


@dataclass(frozen=True)
class Compared:
    """What `compare` finds."""

    verdict: Verdict  # "agrees", "differs", "expected" of the literal method, or "not compared"
    reason: str  # one sentence
    gates: tuple[Gate, ...]  # every number that decides, with its limit
    metrics: dict[str, float | int | None]  # every number measured
    worst: list[dict[str, float | int]]  # the pixels of largest error of colour: row, col, error

    def __str__(self) -> str:
        return f"{self.verdict}: {self.reason}"


def compare(reference: Picture, test: Picture, results: str | Path | None = None) -> Compared:
    """Holds `test` against `reference`, two pictures of one scene with all their planes.

    What each pixel may be off by follows from what the pictures' metadata tell of how they were made: "renderer" or
    "method", "precision" in bits (32 if not told), "errors", for every object how far its surface may be off, and
    "tells_depth". It is measured on the reference tracer, many pictures long, and kept in the folder `results`, if one is
    given, as `raytruth compare --results` does. The literal method against exact intersections is held against its oracle.
    Raises InputError where the two are no pictures of one scene.
    """
    scene = reference.scene
    first, second = _planes(reference), _planes(test)
    if scene.hash != test.scene.hash:
        raise InputError(f"{scene.name} and {test.scene.name} differ in more than names; compare two pictures of one scene")
    truth, other = _run(reference), _run(test)
    error = metrics.pixel_error(first["color"], second["color"])
    found = measured(first, second)
    with nullcontext(results) if results else tempfile.TemporaryDirectory(prefix="raytruth-") as folder:
        kept = Store(Path(folder), conditioning.FOLDER)
        if (truth.settings.get("method"), other.settings.get("method")) == ("exact", "paper"):
            found |= oracle.held(scene, first, second, kept)
            return Compared(*_told(literal(found, scene.tracing.step_size)), found, metrics.worst_pixels(error))
        if None in (*truth.errors, *other.errors):
            return Compared("not compared", unmeasured(truth) or unmeasured(other), (), found, metrics.worst_pixels(error))
        # what is held against the reference's own is a picture that has an accuracy, even where it is the reference's too
        accuracies = [accuracy_of(truth), accuracy_of(other.model_copy(update={"settings": {}}))]
        held = [conditioning.limits(scene, a, kept) for a in {repr(a): a for a in accuracies if a}.values()]
        found |= conditioning.apart(first, second, sum(held[1:], held[0]),
                                    all(p.metadata.get("tells_depth", True) for p in (reference, test)))
    verdict, reason, gates = judge(found, between(truth, other), between(truth, other, exact=True))
    return Compared(*concluded(verdict, reason, truth, other), tuple(gates), found, metrics.worst_pixels(error))


def verdict_on(scene: Scene, name: str, picture: Picture, test: Picture, kept: Store) -> tuple[Verdict, str, list[Gate]]:
    """The verdict on the reference's picture `test`, held against the one of the renderer called `name`: neither is a
    truth, and what they may be apart is what that renderer may be from the reference."""
    run, facts = _run(picture, name), picture.metadata
    a, b = ({**vars(p), "camera": np.array(scene.camera.position)} for p in (test, picture))
    found = measured(a, b)
    if accuracy := accuracy_of(run.model_copy(update={"settings": {}})):
        found |= conditioning.apart(a, b, conditioning.limits(scene, accuracy, kept), facts.get("tells_depth", True))
    verdict, reason, gates = judge(found, tolerance_of(run), tolerance_of(run, exact=True))
    return *concluded(verdict, reason, run), gates


def _run(picture: Picture, name: str | None = None) -> Run:
    """What the picture tells of how it was made, as the suites keep it; `name` is that of its renderer."""
    facts = picture.metadata
    ours = "renderer" not in facts and facts.get("method")
    double = ours and facts.get("precision") == 64
    name = name or facts.get("renderer") or ("paper" if ours == "paper" else "exact" if double else "unknown")
    return Run(key="", scene=picture.scene.name, renderer=name, title=name, state="ok", command="",
               settings={"method": ours} if ours else {}, **{name: facts.get(name, []) for name in OF_OBJECTS},
               facts={k: v for k, v in facts.items() if isinstance(v, (bool, int, float, str))})


def _planes(picture: Picture) -> metrics.Planes:
    camera = picture.scene.camera
    for name in PLANES:
        plane = getattr(picture, name)
        shape = (camera.height, camera.width, *(3,) * (name in ("color", "position", "normal")))
        if np.shape(plane) != shape:
            raise InputError(f"the plane {name} of {picture!r} must be an array of shape {shape}; found "
                             + ("none" if plane is None else str(np.shape(plane))))
    return {**{name: np.asarray(getattr(picture, name)) for name in PLANES}, "camera": np.array(camera.position)}


def _told(verdict: tuple[Verdict, str, list[Gate]]) -> tuple[Verdict, str, tuple[Gate, ...]]:
    return verdict[0], verdict[1], tuple(verdict[2])
