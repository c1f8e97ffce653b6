"""The literal method held against its oracle: the recursive tracer, pixel by pixel.

`paper` is the algorithm's truth. That it differs from exact intersections is its nature only where the method as written
differs: where the recursion, which shares no tracing with it, shows the same. Anything else is a fault.
"""

from __future__ import annotations

import zlib

import numpy as np

from raytruth.reference_tracer.oracle.literal import LiteralSearch, point_color, transmitted
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.scene.placement import is_inside
from raytruth.reference_tracer.tracer.camera import canvas_point, frame
from raytruth.reference_tracer.tracer.render import UNDECIDED
from raytruth.reference_tracer.tracer.sensitivity import DIRECTION_UNITS, ORIGIN_UNITS, PROBES, SAFETY, UNIT

from ..execution.store import Store
from . import conditioning
from .metrics import Planes, everywhere_around, largest_around, pixel_error, uniform_around
from .tolerances import REPEATED

FEWEST = 2000  # pixels that are asked for, or all there are; half of them where the method is likely to err
MOST = 4000  # of the pixels that differ from exact intersections
TOGETHER = 1 << 20  # samples of camera rays that are held at a time
IN_CACHE = 1 << 14  # values of f that are computed at a time: their intermediate arrays stay near the processor
ALIKE = 128  # shadow rays that share an array
EVALUATIONS = 1.5e8  # of f by the oracle: no more pixels are begun then, where paths are many


class AllSteps(LiteralSearch):
    """Samples at t = h, 2 h, ... up to the end of the ray, then the first change of sign, as in sections 4.1 and 4.2.

    NumPy is slow by the call, not by the number: the loop over steps of `LiteralSearch` becomes an axis of an array.
    """

    evaluations = 0

    def _signs_at(self, o, d, t, objects):
        """f < 0 of `objects` at every sample, (n, steps, objects); t is (n, steps)."""
        self.evaluations += t.size * len(objects)
        inside, rows = np.empty((*t.shape, len(objects)), bool), max(1, IN_CACHE // t.shape[1])
        for k, (rotation, center, surface) in enumerate(self.frames[k] for k in objects):
            origin, direction = ((o - center) @ rotation).T, (d @ rotation).T
            for some in (slice(first, first + rows) for first in range(0, len(t), rows)):
                with np.errstate(all="ignore"):
                    f = surface(*(p[some, None] + t[some] * v[some, None] for p, v in zip(origin, direction)))
                inside[some, :, k] = (f < 0) & (f > -np.inf)  # what is not finite counts as outside (M7)
        return inside

    def _samples(self, end):
        """(n, steps): k h, the last one moved to the end of each ray."""
        h = self.tracing.step_size
        return np.minimum(h * np.arange(1, 2 + int(np.max(end, initial=0) / h)), end[:, None])

    def first_hit(self, o, d, inside, limit):
        t_hit, index = np.full(len(d), np.inf), np.full(len(d), -1)
        if not len(d):
            return t_hit, index, np.zeros(0)
        t = self._samples(limit)
        changed = (self._signs_at(o, d, t, range(len(self.frames))) != inside[:, None]) & (limit > 0)[:, None, None]
        ray = np.flatnonzero(changed.any(axis=(1, 2)))
        step = np.argmax(changed.any(axis=2), axis=1)[ray]
        middle = 0.5 * (step * self.tracing.step_size + t[ray, step])
        for k in np.flatnonzero(changed[ray, step].any(axis=0)):
            here = changed[ray, step, k]
            root = self._newton(k, o[ray[here]], d[ray[here]], middle[here])
            closer = root < t_hit[ray[here]]
            t_hit[ray[here][closer]], index[ray[here][closer]] = root[closer], k
        used = limit.copy()
        used[ray] = t[ray, step]
        return t_hit, index, used

    def transmittance(self, o, d, inside, distance):
        intensity, dims = np.ones(len(d)), transmitted(self.scene)
        objects = np.flatnonzero(dims != 1)
        # rays of like length share an array: a short one takes no more samples than the longest of its share
        for some in np.array_split(np.argsort(distance), max(1, len(d) // ALIKE)) if len(objects) and len(d) else ():
            signs = self._signs_at(o[some], d[some], self._samples(distance[some]), objects)
            signs = np.concatenate([inside[some][:, None, objects], signs], axis=1)
            intensity[some] = np.prod(dims[objects] ** np.sum(signs[:, 1:] != signs[:, :-1], axis=1), axis=-1)
        return intensity


def held(scene: Scene, truth: Planes, test: Planes, kept: Store) -> dict[str, float | int | None]:
    """How the literal method's picture of `scene` stands to its oracle, and why it differs from exact intersections.

    A pixel on which the two disagree is excused if rounding may move its colour as far; one that hits something else, or
    elsewhere, only where rounding may change what rays of it or of its neighbours meet.
    """
    asked = shown(scene, chosen(scene, truth, test))
    pixels = asked["pixels"]
    color, t, index = (test[name].reshape(-1, *test[name].shape[2:])[pixels] for name in ("color", "t", "index"))
    error = np.abs(color - asked["color"]).max(axis=-1)
    error = np.where(np.isfinite(error), error, np.where(np.isnan(color) == np.isnan(asked["color"]), 0, np.inf).max(axis=-1))
    same = _same_hit(index, t, asked["index"], asked["t"])
    apart = ~same | ~(error <= REPEATED * (1 + np.abs(asked["color"]).max(axis=-1)))
    excused, at_risk = np.zeros_like(apart), 0
    if apart.any():
        limits = conditioning.limits(scene, conditioning.Accuracy(64), kept, "paper")
        at_risk = int((limits.risk > 0).sum())
        near = (largest_around(limits.risk) > 0).ravel()[pixels]
        with np.errstate(invalid="ignore"):
            near &= (index != asked["index"]) | (index < 0) | (np.abs(t - asked["t"]) <= limits.t_jump.ravel()[pixels])
        elsewhere = np.flatnonzero(apart & ~same & (index == asked["index"]) & (index >= 0))
        same[elsewhere] = np.abs(t[elsewhere] - asked["t"][elsewhere]) <= SAFETY * _shift_by_rounding(scene, pixels[elsewhere])
        apart &= ~(same & (error <= limits.color.ravel()[pixels]))  # ill-conditioned, and beside no edge: no excuse is needed
        excused = apart & (same | near) & (error <= limits.color_jump.ravel()[pixels])
    counted = error[apart & ~excused]
    wrong = differing(truth, test).ravel()
    return {"oracle pixels": len(pixels), "oracle mismatches": int((apart & ~excused).sum()),
            "oracle excused pixels": int(excused.sum()), "pixels at risk": at_risk,
            "oracle color max": float(counted.max(initial=0.0)),
            "pixels unlike exact": int(wrong.sum()), "pixels unlike exact, asked": int(wrong[pixels].sum()),
            **{f"cause: {cause}": count for cause, count in causes(scene, truth, test, pixels[wrong[pixels]]).items()}}


def differing(truth: Planes, test: Planes) -> np.ndarray:
    """Where the literal method shows another object, distance or colour than rounding explains. (h, w)"""
    same = _same_hit(truth["index"], truth["t"], test["index"], test["t"])
    return ~same | ~(pixel_error(truth["color"], test["color"]) <= REPEATED * (1 + np.abs(truth["color"]).max(axis=-1)))


def _same_hit(index, t, other_index, other_t) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return (index == other_index) & ((t == other_t) | (np.abs(t - other_t) <= REPEATED * np.maximum(1, t)))


def chosen(scene: Scene, truth: Planes, test: Planes) -> np.ndarray:
    """Flat indices of the pixels to ask for, in random order: those that differ from the truth, what is around them, edges,
    and any others."""
    random = np.random.default_rng(zlib.crc32(scene.hash.encode()))
    wrong = differing(truth, test)
    near = ~everywhere_around(~wrong) | ~uniform_around(truth["index"])
    found = np.union1d(_some(random, wrong, MOST), _some(random, near, FEWEST // 2))
    found = np.union1d(found, _some(random, np.ones_like(near), FEWEST // 2))
    rest = np.setdiff1d(np.arange(near.size), found)
    found = np.concatenate([found, random.permutation(rest)[:max(FEWEST - len(found), 0)]])
    return random.permutation(found)


def _some(random: np.random.Generator, mask: np.ndarray, most: int) -> np.ndarray:
    return random.permutation(np.flatnonzero(mask))[:most]


def shown(scene: Scene, pixels: np.ndarray) -> dict[str, np.ndarray]:
    """What the recursion shows of the first of these pixels, as many as it can afford: their flat indices, `color` (n, 3),
    and of the rays through their centres `t` and `index`."""
    search, parts = AllSteps(scene), []
    count = max(1, int(TOGETHER * scene.tracing.step_size / scene.tracing.max_distance))
    for first in range(0, len(pixels), count):
        if search.evaluations > EVALUATIONS:
            break
        parts.append(_traced(scene, search, pixels[first:first + count]))
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _traced(scene: Scene, search: AllSteps, pixels: np.ndarray) -> dict[str, np.ndarray]:
    samples = scene.tracing.samples
    inside, limit = _sides(scene, len(pixels)), np.full(len(pixels), scene.tracing.max_distance)
    total = np.zeros((len(pixels), 3))
    for sample in range(samples**2):
        o, d = _rays(scene, pixels, *divmod(sample, samples), samples)
        total += point_color(scene, search, o, d, inside, limit, depth=0)
    t, index, _ = search.first_hit(*_rays(scene, pixels, 0, 0, 1), inside, limit)
    return {"pixels": pixels, "color": total / samples**2, "t": t, "index": index}


def _shift_by_rounding(scene: Scene, pixels: np.ndarray) -> np.ndarray:
    """How far the distance of the hit moves, at most, when the ray through a pixel's centre is moved by a few units of
    rounding (reference_tracer/tracer/sensitivity.py): far, where Newton's method follows noise to a multiple root. (n,)"""
    random, search, inside = np.random.default_rng(len(pixels)), AllSteps(scene), _sides(scene, len(pixels))
    o, d = _rays(scene, pixels, 0, 0, 1)
    limit = np.full(len(pixels), scene.tracing.max_distance)
    t, *_ = search.first_hit(o, d, inside, limit)
    shift = np.zeros(len(pixels))
    for _ in range(PROBES):
        noise = lambda units: random.uniform(-units, units, d.shape) * UNIT[64]
        moved = d + noise(DIRECTION_UNITS)
        moved /= np.linalg.norm(moved, axis=-1, keepdims=True)
        size = np.maximum(1, np.linalg.norm(o, axis=-1, keepdims=True))
        shift = np.fmax(shift, np.abs(search.first_hit(o + noise(ORIGIN_UNITS) * size, moved, inside, limit)[0] - t))
    return np.where(np.isfinite(shift), shift, np.inf)


def _sides(scene: Scene, count: int) -> np.ndarray:
    """Whether the camera is inside, (count, objects)."""
    return np.broadcast_to(np.array([is_inside(obj, scene.camera.position) for obj in scene.objects], bool),
                           (count, len(scene.objects)))


def _rays(scene: Scene, pixels: np.ndarray, sample_row: int, sample_col: int, samples: int):
    row, col = np.divmod(pixels, scene.camera.width)
    camera = frame(scene.camera)
    x, y = canvas_point(camera, row.astype(float), col.astype(float), sample_row, sample_col, samples)
    d = x[:, None] * camera.v_x + y[:, None] * camera.v_y + camera.v_dir
    return np.broadcast_to(camera.v_pos, d.shape), d / np.linalg.norm(d, axis=-1, keepdims=True)


def causes(scene: Scene, truth: Planes, test: Planes, pixels: np.ndarray) -> dict[str, int]:
    """Why the pixels with these flat indices differ from exact intersections, by the rays through their centres."""
    search, inside, h = AllSteps(scene), _sides(scene, len(pixels)), scene.tracing.step_size
    o, d = _rays(scene, pixels, 0, 0, 1)
    (t, k), (exact_t, exact_k) = ((p["t"].ravel()[pixels], p["index"].ravel()[pixels]) for p in (test, truth))
    undecided = truth["status"].ravel()[pixels] == UNDECIDED
    same = _same_hit(exact_k, exact_t, k, t)
    # the samples before and after the exact hit: where the object's side is the same on both, no change of sign was seen
    met = exact_k >= 0
    before = np.floor(np.where(met, exact_t, 0) / h) * h
    side = lambda at: search._signs(o, d, at)[np.arange(len(pixels)), exact_k]
    unseen = met & (np.where(before > 0, side(before), inside[np.arange(len(pixels)), exact_k]) == side(before + h))
    kinds = {"left open by exact intersections": undecided, "in shadow, reflection or refraction rays": same,
             "two roots in one step": unseen & ~(t < exact_t), "Newton left its step": np.ones_like(same)}
    found, left = {}, np.ones_like(same)
    for cause, mask in kinds.items():
        found[cause] = int((left & mask).sum())
        left &= ~mask
    return {cause: count for cause, count in found.items() if count}
