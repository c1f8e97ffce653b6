"""How much each pixel may legitimately differ: its colour's answer to perturbations as small as rounding.

Two faultless renderers round differently. Where a pixel's colour depends smoothly on its rays, the difference stays
near the size of rounding; at a silhouette, a shadow's edge, the critical angle of refraction or (for the literal
method) a step's boundary, rounding decides and the colour may jump. Neither is a method's fault. The map is measured:
every ray of every generation is moved by a few units of rounding, at random, several times over; where a renderer's
surfaces are displaced, or their normals off, so are the reference's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import drjit as dr
import numpy as np

from ..scene.model import Scene
from .given_rays import GivenRays, GivenWorld
from .rays import Ray
from .render import Picture, Renderer, Watch
from .shading import Interaction
from .wavefront import Wave

UNIT = {64: 2.0**-53, 32: 2.0**-24}  # of rounding
ORIGIN_UNITS, DIRECTION_UNITS = 8.0, 4.0  # what a few dozen rounded operations leave in a hit point and a direction
PROBES = 12  # a jump that rounding decides by halves escapes n probes with probability 2^-n
SAFETY = 3.0  # all n uniform samples stay below 1 / SAFETY of their largest possible value with probability SAFETY^-n, 2e-6
FLOOR_UNITS = 64.0  # rounding of the shading itself, relative to 1 + colour

RISKS = OBJECT, LIGHT, TOTAL_REFLECTION = 1, 2, 4  # discrete risks: bits of the risk plane


@dataclass(frozen=True)
class Displaced:
    """How a renderer's surfaces differ from the scene's, a number for every object."""

    errors: tuple[float, ...]  # how far they lie from where they should
    tilts: tuple[float, ...]  # how far their facets turn from them, in radians
    normal_errors: tuple[float, ...]  # how far the normals on them turn from theirs, in radians


class Perturbed(GivenWorld):
    """A world whose rays are moved by random multiples of a `unit` of rounding, and whose normals are turned by up to their
    `angles`, at random, anew for every ray. It knows which objects are `displaced`, and how far their facets are tilted."""

    NORMALS = 1 << 62  # the random numbers that turn normals are another sequence than those that move rays

    def __init__(self, *of_world, displaced: Displaced | None, unit: float, turned: bool, given: GivenRays | None = None):
        super().__init__(*of_world, given=given)
        arrays, nothing = self.arrays, (0.0,) * self.object_count
        errors, tilts, angles = (displaced.errors, displaced.tilts, displaced.normal_errors) if displaced else [nothing] * 3
        self.unit, self.stream = arrays.constant(unit), dr.opaque(arrays.Bits, 0)
        self.tilts, self.angles = self._column((*tilts, 0.0)), self._column((*(angles if turned else nothing), 0.0))
        self.displaced = arrays.UInt([*(int(error > 0 or angle > 0) for error, angle in zip(errors, angles)), 0])
        dr.make_opaque(self.displaced)

    @property
    def variables(self) -> list:
        return [*super().variables, self.unit, self.stream, self.tilts, self.angles, self.displaced]

    def moved(self, wave: Wave) -> Ray:
        arrays, o, d = self.arrays, wave.ray.o, wave.ray.d
        random = arrays.PCG32(len(wave), initstate=self.stream)
        noise = lambda units: arrays.Vector(*(
            (2 * arrays.Float(random.next_float64()) - 1) * (units * self.unit) for _ in range(3)))
        still = self.unit == 0
        o = o + noise(ORIGIN_UNITS) * dr.maximum(1, dr.norm(o))
        return replace(wave.ray, o=o, d=dr.select(still, d, dr.normalize(d + noise(DIRECTION_UNITS))))

    def first_of_tied(self, ray, hit, close):
        """Where rounding decides which of two objects is the nearer, a moved ray shows which it would be."""
        index, undecided = super().first_of_tied(ray, hit, close)
        return dr.select(self.unit == 0, index, hit.index), undecided

    def normal(self, point, index, active):
        normal, arrays = super().normal(point, index, active), self.arrays
        random = arrays.PCG32(dr.width(index), initstate=self.stream, initseq=arrays.Bits(self.NORMALS))
        number = lambda: arrays.Float(random.next_float64())
        across = dr.cross(normal, arrays.Vector(*(2 * number() - 1 for _ in range(3))))
        # evenly over a disc around the tip of the normal: all of 12 stay below 1 / SAFETY of the largest possible answer with
        # probability 3e-5, the 12th power of the share of a disc that lies within a third of its radius from a diameter
        angle = dr.gather(arrays.Float, self.angles, index, active) * dr.sqrt(number())
        turned = normal + across * (angle / dr.norm(across))
        return dr.select(angle > 0, turned / dr.norm(turned), normal)

    def grazing(self, interaction: Interaction):
        """How much of its colour (its brightest channel) a point has from lights lower above the surface than its facets are
        tilted: a facet beside the one that is hit may stand in their way."""
        hit = interaction.hit
        met = hit.index < self.object_count
        tilt, material = dr.gather(self.arrays.Float, self.tilts, hit.index), self.material(hit.index, met)
        R, T = material.reflection if self.reflective else 0.0, material.transparency if self.transparent else 0.0
        total, position, brightness = self.arrays.Float(0), *self._light_columns
        for j in range(len(self.scene.lights)):
            at = lambda columns: self.arrays.Vector(*(dr.gather(self.arrays.Float, c, self.arrays.UInt(j)) for c in columns))
            cos = dr.dot(dr.normalize(at(position) - interaction.point), interaction.normal)
            low = met & (cos > 0) & (cos <= tilt)
            total += dr.select(low, cos * dr.max(material.color * at(brightness)), 0)
        return total * (1.0 - R) * (1.0 - T)


@dataclass
class Marks:
    """What the rays of a band's pixels have met, an entry a slot."""

    sums: list  # UInt, of hashes of each risk's history: they do not depend on the order in which rays are traced
    met: object  # UInt, whether any ray met an object that is displaced
    unsure: object  # Float, of its colour, see `Perturbed.grazing`


class Marker:
    """Moves the rays of waves and marks what they meet (wavefront.Recorder)."""

    def __init__(self):
        self.marks, self.seed, self.wave_number = None, 0, 0

    def begin_wave(self, world: Perturbed) -> None:
        self.wave_number += 1
        world.stream = dr.opaque(world.arrays.Bits, 1000003 * self.seed + self.wave_number)

    def disturb(self, world: Perturbed, wave: Wave) -> Ray:
        return world.moved(wave)

    def observe(self, world: Perturbed, wave: Wave, generation, interaction: Interaction) -> None:
        UInt, active, index = world.arrays.UInt, wave.weight > 0, interaction.hit.index
        place = (index + 1) * 0x9E3779B1 ^ generation * 0x85EBCA77
        total = interaction.total_reflection
        parts = {OBJECT: place * 0xC2B2AE3D, LIGHT: place * (interaction.lights_reached + 1),
                 TOTAL_REFLECTION: UInt(0) if total is None else dr.select(total, place, 0)}
        for k, risk in enumerate(RISKS):
            dr.scatter_add(self.marks.sums[k], dr.select(active, parts[risk], 0), wave.slot, mode=dr.ReduceMode.Direct)
        dr.scatter_reduce(dr.ReduceOp.Max, self.marks.met, dr.gather(UInt, world.displaced, index), wave.slot, active,
                          mode=dr.ReduceMode.Direct)
        dr.scatter_add(self.marks.unsure, world.grazing(interaction) * wave.weight, wave.slot, active,
                       mode=dr.ReduceMode.Direct)


class Perturbations(Watch):
    """Pictures of `scene`, perturbed. All are replays of one recording: their worlds differ in numbers alone."""

    def __init__(self, scene: Scene, method: str, displaced: Displaced | None = None, given: GivenRays | None = None):
        self.scene, self.displaced, self.given, self.recorder = scene, displaced, given, Marker()
        self._renderer = Renderer(scene, method, world=self._world(0.0, turned=False))

    def _world(self, unit: float, turned: bool):
        return partial(Perturbed, displaced=self.displaced, unit=unit, turned=turned, given=self.given)

    def picture(self, unit: float, seed: int) -> Picture:
        """Every ray moved by multiples of `unit`, surfaces displaced and normals turned; `seed` 0 leaves these as they are.

        What it marks stays until the next: `signatures` of every pixel's history, flat, for each risk; `touched` and
        `grazing`, (h, w), as in `Response`.
        """
        moved = self.displaced is not None and seed > 0
        pixels, self.recorder.seed, self.recorder.wave_number = self.scene.camera.width * self.scene.camera.height, seed, 0
        self.signatures = {risk: np.zeros(pixels, np.uint32) for risk in RISKS}
        self._touched, self._grazing = np.zeros(pixels, bool), np.zeros(pixels)
        self._renderer.show(_moved(self.scene, self.displaced.errors, seed) if moved else self.scene, self._world(unit, moved))
        found = self._renderer.picture(watch=self)
        self.touched, self.grazing = (plane.reshape(found.t.shape) for plane in (self._touched, self._grazing))
        return found

    def begin(self, world, first, count):
        self._where, self._count, slots = slice(first, first + count), count, max(count, 2)
        self.recorder.marks = Marks([dr.zeros(world.arrays.UInt, slots) for _ in RISKS], dr.zeros(world.arrays.UInt, slots),
                                    dr.zeros(world.arrays.Float, slots))
        dr.make_opaque(self.recorder.marks)

    def end(self):
        marks, of_band = self.recorder.marks, lambda array: array.numpy()[:self._count]
        self._touched[self._where], self._grazing[self._where] = of_band(marks.met) > 0, of_band(marks.unsure)
        for risk, total in zip(RISKS, marks.sums):
            self.signatures[risk][self._where] = of_band(total)


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
             displaced: Displaced | None = None, progress=lambda share: None, given: GivenRays | None = None,
             recorded: dict[str, Perturbations] | None = None) -> Response:
    """Measures what rounding to `precision` bits may change, and surfaces that are `displaced`; of the rays `given`, where
    there are any, in place of the camera's. What is `recorded` of a scene, by its hash, is replayed and added to; of one
    `method` only, and not of `given` rays."""
    if given:
        return _response(Perturbations(given.scene(scene), method, displaced, given), precision, probes, progress)
    recorded = {} if recorded is None else recorded
    if scene.tracing.samples > 1:  # first hits are those of the ray through a pixel's centre
        centre = response(scene.traced_with(samples=1), method, precision, probes, displaced, recorded=recorded)
        found = _response(_perturbations(scene, method, displaced, recorded), precision, probes, progress)
        for name in ("t", "normal"):
            found.smooth[name], found.jump[name] = centre.smooth[name], centre.jump[name]
        return replace(found, seen=centre.seen, risk=found.risk | centre.risk)
    return _response(_perturbations(scene, method, displaced, recorded), precision, probes, progress)


def _perturbations(scene: Scene, method: str, displaced: Displaced | None, recorded: dict[str, Perturbations]) -> Perturbations:
    if scene.hash not in recorded:
        recorded[scene.hash] = Perturbations(scene, method)
    recorded[scene.hash].displaced = displaced
    return recorded[scene.hash]


def _response(made: Perturbations, precision: int, probes: int, progress) -> Response:
    truth = made.picture(0.0, seed=0)
    shape, signatures = truth.t.shape, made.signatures
    found = Response(truth, *({name: np.zeros(shape) for name in ("color", "t", "normal")} for _ in range(2)),
                     np.zeros(shape, np.uint8), _bit(truth.index), made.touched, made.grazing)
    for k in range(probes):
        probe = made.picture(UNIT[precision], seed=k + 1)
        changed = np.zeros(shape, bool)
        for kind, signature in made.signatures.items():
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
        found.touched |= made.touched
        found.grazing = np.fmax(found.grazing, made.grazing)
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
    made = Perturbations(scene, method)
    return made.picture(unit, seed), made.signatures


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
