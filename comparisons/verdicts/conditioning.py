"""How far a renderer's picture may be from the reference's, pixel by pixel.

A pixel is held to what follows from the objects on its path: rounding to the renderer's precision, and how far its meshes
or grids, and the normals on them, are from the surfaces they stand for. Both are measured on the reference itself, by
perturbation (reference_tracer/tracer/sensitivity.py), at the price of many pictures, and kept by content.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np

from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.given_rays import GivenRays
from raytruth.reference_tracer.tracer.render import UNDECIDED
from raytruth.reference_tracer.tracer.sensitivity import (
    FLOOR_UNITS,
    PROBES,
    SAFETY,
    UNIT,
    Displaced,
    Perturbations,
    perturbed,
    response,
)

from ..execution import store
from ..execution.store import Store
from ..execution.worker import tell
from .metrics import Planes, interior, largest_around, neighbours, uniform_around

FOLDER = "limits"
UP = 1 + 2.0**-20  # what is kept in single precision is rounded up


@dataclass(frozen=True)
class Accuracy:
    """What a renderer can do: the bits of its numbers, the errors of its surfaces, how finely it writes its planes."""

    precision: int
    errors: tuple[float, ...] = ()  # a number for every object; none: all are exact
    tilts: tuple[float, ...] = ()
    normal_errors: tuple[float, ...] = ()
    color: float = 0.0  # absolute
    t: float = 0.0  # relative
    normal: float = 0.0

    @property
    def displaced(self) -> Displaced | None:
        if not any((*self.errors, *self.normal_errors)):
            return None
        return Displaced(self.errors, self.tilts, self.normal_errors or (0.0,) * len(self.errors))


@dataclass(frozen=True)
class Limits:
    """Planes (h, w). Within `color`, `t` and `normal` a pixel agrees; within the others it is excused where `risk` says
    that a ray of it or of a neighbour may meet something else."""

    color: np.ndarray
    t: np.ndarray
    normal: np.ndarray
    color_jump: np.ndarray
    t_jump: np.ndarray
    normal_jump: np.ndarray
    risk: np.ndarray  # uint8, of the pixel itself
    seen: np.ndarray  # uint64, of the pixel and its neighbours
    touched: np.ndarray  # bool
    decided: np.ndarray  # bool

    def __add__(self, other: Limits) -> Limits:
        """Of two renderers against each other: each may be as far from the truth as its own limits say."""
        return Limits(*(a + b for a, b in zip(_planes(self)[:6], _planes(other)[:6])), self.risk | other.risk,
                      self.seen | other.seen, self.touched | other.touched, self.decided & other.decided)


def _planes(limits: Limits) -> list[np.ndarray]:
    return [getattr(limits, field.name) for field in fields(limits)]


def accuracy_from(told: dict) -> Accuracy:
    """The accuracy that `asdict` told, by way of JSON."""
    return Accuracy(**{name: tuple(value) if isinstance(value, list) else value for name, value in told.items()})


def make(arguments: dict) -> dict:
    """In a worker: measures the limits of all `accuracies` on a scene, which are kept for all who ask for them."""
    scene, kept = parse_scene(arguments["scene"].encode(), "scene"), Store(Path(arguments["results"]), FOLDER)
    recorded: dict[str, Perturbations] = {}
    for k, accuracy in enumerate(arguments["accuracies"]):
        tell(f"accuracy {k + 1} of {len(arguments['accuracies'])}", k / len(arguments["accuracies"]))
        limits(scene, accuracy_from(accuracy), kept, recorded=recorded)
    return {"state": "ok"}


def limits(scene: Scene, accuracy: Accuracy, kept: Store, method: str = "exact", given: GivenRays | None = None,
           recorded: dict[str, Perturbations] | None = None) -> Limits:
    """The limits of a renderer of `accuracy` on `scene`, against the reference's `method`; or on the rays `given`. `recorded`
    as in sensitivity.response."""
    if (found := kept_limits(scene.hash, accuracy, kept, method, given)) is not None:
        return found
    key = key_of(scene.hash, accuracy, method, given)
    made = _measured(scene, accuracy, method, given, recorded)
    planes = {name: plane.astype(np.float32) * np.float32(UP) if plane.dtype == float else plane
              for name, plane in vars(made).items()}
    store.save(kept.file(key), **planes)
    kept.keep(key, {}, arrays=True)
    return Limits(**planes)


def kept_limits(scene_hash: str, accuracy: Accuracy, kept: Store, method: str = "exact",
                given: GivenRays | None = None) -> Limits | None:
    """The limits of a renderer of `accuracy`, if they have been measured on the scene of that hash."""
    found = kept.arrays(key_of(scene_hash, accuracy, method, given))
    return found and Limits(**{name: found[name] for name in Limits.__annotations__})


def key_of(scene_hash: str, accuracy: Accuracy, method: str = "exact", given: GivenRays | None = None) -> str:
    rays = [given.o.tolist(), given.d.tolist()] if given else []
    return store.key(scene_hash, method, asdict(accuracy), PROBES, *rays, made_by=(__name__,))


def _measured(scene: Scene, accuracy: Accuracy, method: str, given: GivenRays | None,
              recorded: dict[str, Perturbations] | None) -> Limits:
    found = response(scene, method, accuracy.precision, displaced=accuracy.displaced, given=given, recorded=recorded)
    # an edge that no perturbation moved across this pixel may have been moved across its neighbour; rays have none
    around = (lambda plane: plane) if given else largest_around
    picture, rounding = found.picture, FLOOR_UNITS * UNIT[accuracy.precision]
    t = np.where(np.isfinite(picture.t), picture.t, 0)
    floors = {"color": accuracy.color + found.grazing + rounding * (1 + np.abs(picture.color).max(axis=-1)),
              "t": accuracy.t * t + rounding * np.maximum(1, t), "normal": accuracy.normal + rounding + 0 * t}
    within, jumps = ({name: SAFETY * around(moved[name]) + floors[name] for name in floors}
                     for moved in (found.smooth, found.jump))
    return Limits(**within, **{f"{name}_jump": limit for name, limit in jumps.items()}, risk=found.risk,
                  seen=found.seen if given else np.bitwise_or.reduce(list(neighbours(found.seen))), touched=found.touched,
                  decided=picture.status != UNDECIDED)


def kinds(a: Planes, b: Planes, limits: Limits, tells_depth: bool = True) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """For each plane of a picture, first to last: where `b` keeps its limit there, and where rounding, or the errors of
    surfaces, may explain it if it does not. (h, w) each. Planes that `b` lacks are left out."""
    met = np.isfinite(a["t"]) | np.isfinite(b.get("t", np.nan))
    if "index" in b:
        met = (a["index"] == b["index"]) & (a["index"] >= 0)
    found = {}
    if "index" in b:
        bits = np.uint64(1) << ((b["index"] + 1) % 64).astype(np.uint64)
        other = np.uint64(1) << ((a["index"] + 1) % 64).astype(np.uint64)
        found["object"] = a["index"] == b["index"], (bits & limits.seen > 0) & (other & limits.seen > 0)
    with np.errstate(invalid="ignore"):
        if "t" in b:
            off = np.where(met, np.abs(a["t"] - b["t"]), 0)
            found["distance"] = off <= limits.t, off <= limits.t_jump
        if "position" in b:  # o + t d is rounded once more
            off = np.where(met, np.linalg.norm(a["position"] - b["position"], axis=-1), 0)
            size = 1 + np.where(met, np.nan_to_num(np.abs(a["position"]).max(-1)), 0)
            found["position"] = off <= limits.t * size, off <= limits.t_jump * size
        if "normal" in b:
            off = np.where(met, np.linalg.norm(a["normal"] - b["normal"], axis=-1), 0)
            found["normal"] = off <= limits.normal, off <= limits.normal_jump
        if "depth" in b:
            found["generation"] = a["depth"] == b["depth"] if tells_depth else np.ones_like(met), np.ones_like(met)
        off = np.abs(a["color"] - b["color"]).max(-1)
        found["color"] = off <= limits.color, off <= limits.color_jump
    return found


def apart(a: Planes, b: Planes, limits: Limits, tells_depth: bool = True) -> dict[str, float | int | None]:
    """How many pixels differ, and in which plane first, how many are excused, and how many could be at most.

    A pixel differs if any of its planes is beyond its limit, unless rounding, or the errors of surfaces, explain it: an
    edge runs through the pixel or beside it. It is excused if what is shown is what the reference itself shows when it is
    perturbed, and unforeseen if it is not: a further picture exceeds all of n in a pixel with probability 1 / (n + 1).
    """
    excusable = largest_around(limits.risk) > 0
    met = (a["index"] == b["index"]) & (a["index"] >= 0)
    planes = kinds(a, b, limits, tells_depth)
    within = np.logical_and.reduce([w for w, _ in planes.values()])
    explained = excusable & np.logical_and.reduce([w | e for w, e in planes.values()])
    wrong, left = limits.decided & ~within & ~excusable, np.ones_like(within)
    found: dict[str, float | int | None] = {
        "differing pixels": int(wrong.sum()), "excused pixels": int((limits.decided & ~within & explained).sum()),
        "unforeseen pixels": int((limits.decided & ~within & ~explained & excusable).sum()),
        "undecided pixels": int((~limits.decided).sum()), "pixels at risk": int((limits.risk > 0).sum())}
    for kind, (w, _) in planes.items():
        here = wrong & left & ~w
        left &= ~here
        if here.any():
            found[f"differing in {kind}"] = int(here.sum())
    exact = ~limits.touched
    found["displaced pixels"] = int(limits.touched.sum())
    found["exact pixels"], steady = int(exact.sum()), exact & met & ~excusable
    found["exact hit pixels"] = int(steady.sum())
    p99 = lambda values: float(np.quantile(values, 0.99)) if len(values) else None
    found["color p99, exact shapes"] = p99(np.abs(a["color"] - b["color"]).max(-1)[exact])
    found["depth p99, exact shapes"] = p99(np.abs(a["t"][steady] - b["t"][steady]) / a["t"][steady])
    return found


def smooth(scene: Scene, planes: Planes) -> np.ndarray:
    """Pixels that lie away from silhouettes seen directly, in mirrors or through glass, and from shadows' edges. (h, w)

    Every ray of every generation of the 3 x 3 pixels around meets the same objects, reaches as many lights and is
    totally reflected or not. `planes` are the reference's.
    """
    picture, signatures = perturbed(scene, "exact", 0.0, seed=0)
    shape = picture.t.shape
    return np.logical_and.reduce([interior(planes), *(uniform_around(s.reshape(shape)) for s in signatures.values())])
