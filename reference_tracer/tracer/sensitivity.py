"""How much each pixel may legitimately differ: its colour's answer to perturbations as small as rounding.

Two faultless renderers round differently. Where a pixel's colour depends smoothly on its rays, the difference stays
near the size of rounding; at a silhouette, a shadow's edge, the critical angle of refraction or (for the literal
method) a step's boundary, rounding decides and the colour may jump. Neither is a method's fault. The map is measured:
every ray of every generation is moved by a few units of rounding, at random, several times over.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import drjit as dr
import numpy as np

from ..scene.model import Scene
from .given_rays import GivenRays
from .rays import Ray
from .render import Picture, Watch, render
from .shading import Interaction
from .wavefront import Wave

UNIT = {64: 2.0**-53, 32: 2.0**-24}  # of rounding
ORIGIN_UNITS, DIRECTION_UNITS = 8.0, 4.0  # what a few dozen rounded operations leave in a hit point and a direction
PROBES = 12  # a jump that rounding decides by halves escapes n probes with probability 2^-n
SAFETY = 3.0  # all n uniform samples stay below 1 / SAFETY of their largest possible value with probability SAFETY^-n, 2e-6
FLOOR_UNITS = 64.0  # rounding of the shading itself, relative to 1 + colour

OBJECT, LIGHT, TOTAL_REFLECTION = 1, 2, 4  # discrete risks: bits of the risk plane


class Perturbation(Watch):
    """Moves every ray by random multiples of rounding, and notes what each pixel's rays meet."""

    def __init__(self, unit: float, seed: int, pixels: int, displaced: Displaced | None = None,
                 given: GivenRays | None = None):
        self.unit, self.seed, self.wave_number = unit, seed, 0
        self.signatures = {risk: np.zeros(pixels, np.uint32) for risk in (OBJECT, LIGHT, TOTAL_REFLECTION)}
        self.given = given
        self.displaced, self.touched, self.grazing = displaced, np.zeros(pixels, bool), np.zeros(pixels)

    def begin(self, world, first, count):
        self.world, self.where, self.count = world, slice(first, first + count), count
        self.sums = {risk: dr.zeros(world.arrays.UInt, max(count, 2)) for risk in self.signatures}
        self.met, self.unsure = dr.zeros(world.arrays.UInt, max(count, 2)), dr.zeros(world.arrays.Float, max(count, 2))
        dr.make_opaque(list(self.sums.values()), self.met, self.unsure)
        if self.displaced:
            self.moves = world.arrays.UInt([int(error > 0) for error in self.displaced.errors] + [0])
            self.tilts = world.arrays.Float([*map(float, self.displaced.tilts), 0.0])
            dr.make_opaque(self.moves, self.tilts)

    def disturb(self, wave: Wave) -> Ray:
        arrays = self.world.arrays
        wave = self.given.in_place_of(wave, self.world) if self.given else wave
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
        return replace(wave.ray, o=o, d=d)

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
            dr.scatter_reduce(dr.ReduceOp.Max, self.met, dr.gather(UInt, self.moves, interaction.hit.index), wave.slot, active,
                              mode=dr.ReduceMode.Direct)
            dr.scatter_add(self.unsure, self._grazing(wave, interaction), wave.slot, active, mode=dr.ReduceMode.Direct)
        dr.eval(list(self.sums.values()), self.met, self.unsure)

    def _grazing(self, wave: Wave, interaction: Interaction):
        """How much of a pixel's colour (its brightest channel) comes from lights lower above the surface than its facets are
        tilted: a facet beside the one that is hit may stand in their way."""
        world, hit = self.world, interaction.hit
        met = hit.index < world.object_count
        tilt, material = dr.gather(world.arrays.Float, self.tilts, hit.index), world.material(hit.index, met)
        R, T = material.reflection if world.reflective else 0.0, material.transparency if world.transparent else 0.0
        total = world.arrays.Float(0)
        for light in world.scene.lights:
            cos = dr.dot(dr.normalize(world.arrays.Vector(*light.position) - interaction.point), interaction.normal)
            low = met & (cos > 0) & (cos <= tilt)
            total += dr.select(low, cos * dr.max(material.color * world.arrays.Vector(*light.brightness)), 0)
        return total * (1.0 - R) * (1.0 - T) * wave.weight

    def end(self):
        self.touched[self.where] = self.met.numpy()[:self.count] > 0
        self.grazing[self.where] = self.unsure.numpy()[:self.count]
        for risk, total in self.sums.items():
            self.signatures[risk][self.where] = total.numpy()[:self.count]


@dataclass(frozen=True)
class Displaced:
    """How a renderer's surfaces differ from the scene's, a number for every object."""

    errors: tuple[float, ...]  # how far they lie from where they should
    tilts: tuple[float, ...]  # how far their facets turn from them, in radians


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
    grazing: np.ndarray  # of its colour, from lights lower above a displaced object than its facets are tilted


def response(scene: Scene, method: str = "exact", precision: int = 32, probes: int = PROBES,
             displaced: Displaced | None = None, progress=lambda share: None, given: GivenRays | None = None) -> Response:
    """Measures what rounding to `precision` bits may change, and surfaces that are `displaced`; of the rays `given`, where
    there are any, in place of the camera's."""
    if given:
        return _response(given.scene(scene), method, precision, probes, displaced, progress, given)
    if scene.tracing.samples > 1:  # first hits are those of the ray through a pixel's centre
        centre = response(scene.traced_with(samples=1), method, precision, probes, displaced)
        found = _response(scene, method, precision, probes, displaced, progress)
        for name in ("t", "normal"):
            found.smooth[name], found.jump[name] = centre.smooth[name], centre.jump[name]
        return replace(found, seen=centre.seen, risk=found.risk | centre.risk)
    return _response(scene, method, precision, probes, displaced, progress)


def _response(scene: Scene, method: str, precision: int, probes: int, displaced: Displaced | None, progress,
              given: GivenRays | None = None) -> Response:
    truth, watch = _perturbed(scene, method, 0.0, 0, displaced, given)
    shape, signatures = truth.t.shape, watch.signatures
    found = Response(truth, *({name: np.zeros(shape) for name in ("color", "t", "normal")} for _ in range(2)),
                     np.zeros(shape, np.uint8), _bit(truth.index), watch.touched.reshape(shape), watch.grazing.reshape(shape))
    for k in range(probes):
        probe, watch = _perturbed(scene, method, UNIT[precision], k + 1, displaced, given)
        changed = np.zeros(shape, bool)
        for kind, signature in watch.signatures.items():
            differs = (signature != signatures[kind]).reshape(shape)
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
        found.touched |= watch.touched.reshape(shape)
        found.grazing = np.fmax(found.grazing, watch.grazing.reshape(shape))
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
    picture, watch = _perturbed(scene, method, unit, seed, None)
    return picture, watch.signatures


def _perturbed(scene: Scene, method: str, unit: float, seed: int, displaced: Displaced | None,
               given: GivenRays | None = None) -> tuple[Picture, Perturbation]:
    """The same with surfaces displaced; `seed` 0 leaves them in their places."""
    camera = scene.camera
    watch = Perturbation(unit, seed, camera.width * camera.height, displaced, given)
    return render(_moved(scene, displaced.errors, seed) if displaced and seed else scene, method, watch=watch), watch


def _moved(scene: Scene, errors: Sequence[float], seed: int) -> Scene:
    """`scene` with each object moved along an axis so far that some `seed` of six in a row, one a direction of an axis, moves
    its surface by `errors` along the normal, wherever that points. No two neighbours in scene order move alike."""
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
