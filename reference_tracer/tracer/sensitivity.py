"""How much each pixel may legitimately differ: its colour's answer to perturbations as small as rounding.

Two faultless renderers round differently. Where a pixel's colour depends smoothly on its rays, the difference stays
near the size of rounding; at a silhouette, a shadow's edge, the critical angle of refraction or (for the literal
method) a step's boundary, rounding decides and the colour may jump. Neither is a method's fault. The map is measured:
every ray of every generation is moved by a few units of rounding, at random, several times over.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import drjit as dr
import numpy as np

from ..scene.model import Scene
from .rays import Ray
from .render import Picture, Watch, render
from .shading import Interaction
from .wavefront import Wave

UNIT = {64: 2.0**-53, 32: 2.0**-24}  # of rounding
ORIGIN_UNITS, DIRECTION_UNITS = 8.0, 4.0  # what a few dozen rounded operations leave in a hit point and a direction
PROBES = 8
SAFETY = 3.0  # a further perturbation exceeds the largest of eight by this factor only if the colour jumps
FLOOR_UNITS = 64.0  # rounding of the shading itself, relative to 1 + colour

OBJECT, LIGHT, TOTAL_REFLECTION = 1, 2, 4  # discrete risks: bits of the risk plane


class Perturbation(Watch):
    """Moves every ray by random multiples of rounding, and notes what each pixel's rays meet."""

    def __init__(self, unit: float, seed: int, pixels: int, displaced: Sequence[int] = ()):
        self.unit, self.seed, self.wave_number = unit, seed, 0
        self.signatures = {risk: np.zeros(pixels, np.uint32) for risk in (OBJECT, LIGHT, TOTAL_REFLECTION)}
        self.displaced, self.touched = displaced, np.zeros(pixels, bool)

    def begin(self, world, first, count):
        self.world, self.where, self.count = world, slice(first, first + count), count
        self.sums = {risk: dr.zeros(world.arrays.UInt, max(count, 2)) for risk in self.signatures}
        self.met = dr.zeros(world.arrays.UInt, max(count, 2))
        self.moves = world.arrays.UInt([int(k in self.displaced) for k in range(len(world.scene.objects))] + [0])
        dr.make_opaque(list(self.sums.values()), self.met, self.moves)

    def disturb(self, wave: Wave) -> Ray:
        arrays = self.world.arrays
        self.wave_number += 1
        if not self.unit:
            return wave.ray
        random = arrays.PCG32(len(wave), initstate=arrays.Bits(dr.opaque(arrays.Bits, 1000003 * self.seed + self.wave_number)))
        noise = lambda units: arrays.Vector(*(
            (2 * arrays.Float(random.next_float64()) - 1) * arrays.constant(units * self.unit) for _ in range(3)))
        o, d = wave.ray.o, wave.ray.d
        o = o + noise(ORIGIN_UNITS) * dr.maximum(1, dr.norm(o))
        d = dr.normalize(d + noise(DIRECTION_UNITS))
        dr.eval(o, d)
        return Ray(o, d, wave.ray.sides)

    def observe(self, wave: Wave, interaction: Interaction) -> None:
        UInt = self.world.arrays.UInt
        active = wave.weight > 0
        # sums of hashes do not depend on the order in which a pixel's rays are traced
        place = (interaction.hit.index + 1) * 0x9E3779B1 ^ self.world.generation(wave.generation) * 0x85EBCA77
        parts = {OBJECT: place * 0xC2B2AE3D, LIGHT: place * (interaction.lights_reached + 1)}
        if interaction.refracted_weight is not None:
            parts[TOTAL_REFLECTION] = dr.select(interaction.total_reflection, place, UInt(0))
        for risk, value in parts.items():
            dr.scatter_add(self.sums[risk], dr.select(active, value, 0), wave.slot, mode=dr.ReduceMode.Direct)
        if self.displaced:
            dr.scatter_reduce(dr.ReduceOp.Max, self.met, dr.gather(UInt, self.moves, collision.hit.index), wave.slot, active,
                              mode=dr.ReduceMode.Direct)
        dr.eval(list(self.sums.values()), self.met)

    def end(self):
        self.touched[self.where] = self.met.numpy()[:self.count] > 0
        for risk, total in self.sums.items():
            self.signatures[risk][self.where] = total.numpy()[:self.count]


@dataclass
class Response:
    """How pixels answer perturbations; planes are (h, w).

    `smooth` has the largest change of "color", "t" and "normal" (length of the difference) over all perturbations that
    leave the pixel's history as it is: what its rays meet, how many lights they reach, where they are totally reflected.
    `jump` has the largest change of all. Distances and normals count where the same object is hit.
    """

    picture: Picture
    smooth: dict[str, np.ndarray]
    jump: dict[str, np.ndarray]
    risk: np.ndarray  # uint8, bits OBJECT, LIGHT, TOTAL_REFLECTION: a perturbation changed the pixel's history
    seen: np.ndarray  # uint64, bit (k + 1) % 64 of every object k (-1: none) that the ray through its centre has met
    touched: np.ndarray  # bool, whether any ray of the pixel meets an object that is displaced


def response(scene: Scene, method: str = "exact", precision: int = 32, probes: int = PROBES, errors: Sequence[float] = (),
             progress=lambda share: None) -> Response:
    """Measures what rounding to `precision` bits may change, and surfaces that lie up to `errors` off their places, one
    distance for every object."""
    truth, signatures, touched = _perturbed(scene, method, 0.0, 0, errors)
    found = Response(truth, *({name: np.zeros(truth.t.shape) for name in ("color", "t", "normal")} for _ in range(2)),
                     np.zeros(truth.t.shape, np.uint8), _bit(truth.index), touched)
    for k in range(probes):
        probe, others, touched = _perturbed(scene, method, UNIT[precision], k + 1, errors)
        changed = np.zeros_like(found.touched)
        for kind, signature in others.items():
            differs = (signature != signatures[kind]).reshape(changed.shape)
            found.risk |= np.where(differs, kind, 0).astype(np.uint8)
            changed |= differs
        same = (probe.index == truth.index) & (truth.index >= 0)
        with np.errstate(invalid="ignore"):
            for name, moved in (("color", np.abs(probe.color - truth.color).max(-1)),
                                ("t", np.where(same, np.abs(probe.t - truth.t), 0)),
                                ("normal", np.where(same, np.linalg.norm(probe.normal - truth.normal, axis=-1), 0))):
                found.jump[name] = np.fmax(found.jump[name], moved)
                found.smooth[name] = np.fmax(found.smooth[name], np.where(changed, 0, moved))
        found.seen |= _bit(probe.index)
        found.touched |= touched
        progress((k + 1) / probes)
    return found


def _bit(index: np.ndarray) -> np.ndarray:
    return np.uint64(1) << ((index + 1) % 64).astype(np.uint64)


@dataclass
class Sensitivity:
    """The map. `bound` is for comparisons with a renderer of `precision` bits, (h, w), in units of colour."""

    bound: np.ndarray
    risk: np.ndarray  # (h, w) uint8, bits OBJECT, LIGHT, TOTAL_REFLECTION: rounding may change the pixel's history
    precision: int
    picture: Picture

    def excuses(self, other: np.ndarray) -> np.ndarray:
        """Where the difference between `other`'s colours (h, w, 3) and the picture's lies within the bound. (h, w)"""
        return np.abs(other - self.picture.color).max(axis=-1) <= self.bound


def sensitivity(scene: Scene, method: str = "exact", precision: int = 32, probes: int = PROBES,
                progress=lambda share: None) -> Sensitivity:
    """Measures how far rounding to `precision` bits may move every pixel of `scene` under `method`."""
    found = response(scene, method, precision, probes, progress=progress)
    # an edge that a few probes never crossed in this pixel may be crossed in it by another: the neighbours know of it
    bound = SAFETY * _largest_around(found.jump["color"]) + floor(precision, found.picture.color)
    return Sensitivity(bound, found.risk, precision, found.picture)


def floor(precision: int, color: np.ndarray) -> np.ndarray:
    """(h, w): what rounding of the shading itself changes in colours (h, w, 3)."""
    return FLOOR_UNITS * UNIT[precision] * (1 + np.abs(color).max(axis=-1))


def perturbed(scene: Scene, method: str, unit: float, seed: int) -> tuple[Picture, dict[int, np.ndarray]]:
    """The picture with every ray moved by multiples of `unit`, and for each risk a signature of every pixel's history."""
    return _perturbed(scene, method, unit, seed, ())[:2]


def _perturbed(scene: Scene, method: str, unit: float, seed: int, errors: Sequence[float]):
    """The same with surfaces displaced, and the pixels whose rays meet one of them (h, w)."""
    camera = scene.camera
    watch = Perturbation(unit, seed, camera.width * camera.height, [k for k, error in enumerate(errors) if error])
    picture = render(_displaced(scene, errors, seed) if seed else scene, method, watch=watch)
    return picture, watch.signatures, watch.touched.reshape(camera.height, camera.width)


def _displaced(scene: Scene, errors: Sequence[float], seed: int) -> Scene:
    """`scene` with each object moved along an axis so far that some `seed` of six in a row, one a direction of an axis, moves
    its surface by `errors` along the normal, wherever that points. No two neighbours in scene order move alike."""
    if not any(errors):
        return scene
    moved = []
    for k, (obj, error) in enumerate(zip(scene.objects, errors)):
        turn = (seed + (1 + seed // 6) * k) % 6
        way = np.zeros(3)
        way[turn % 3] = (1 if turn < 3 else -1) * 3**0.5 * error
        center = tuple(float(c) for c in np.array(obj.surface.center) + way)
        moved.append(obj.model_copy(update={"surface": obj.surface.model_copy(update={"center": center})}))
    return scene.model_copy(update={"objects": tuple(moved)})


def _largest_around(plane: np.ndarray) -> np.ndarray:
    h, w = plane.shape
    padded = np.pad(plane, 1, mode="edge")
    return np.maximum.reduce([padded[i:i + h, j:j + w] for i in range(3) for j in range(3)])
