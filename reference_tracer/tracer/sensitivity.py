"""How much each pixel may legitimately differ: its colour's answer to perturbations as small as rounding.

Two faultless renderers round differently. Where a pixel's colour depends smoothly on its rays, the difference stays
near the size of rounding; at a silhouette, a shadow's edge, the critical angle of refraction or (for the literal
method) a step's boundary, rounding decides and the colour may jump. Neither is a method's fault. The map is measured:
every ray of every generation is moved by a few units of rounding, at random, several times over.
"""

from __future__ import annotations

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

    def __init__(self, unit: float, seed: int, pixels: int):
        self.unit, self.seed, self.wave_number = unit, seed, 0
        self.signatures = {risk: np.zeros(pixels, np.uint32) for risk in (OBJECT, LIGHT, TOTAL_REFLECTION)}

    def begin(self, world, first, count):
        self.world, self.where, self.count = world, slice(first, first + count), count
        self.sums = {risk: dr.zeros(world.arrays.UInt, max(count, 2)) for risk in self.signatures}
        dr.make_opaque(list(self.sums.values()))

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
        dr.eval(list(self.sums.values()))

    def end(self):
        for risk, total in self.sums.items():
            self.signatures[risk][self.where] = total.numpy()[:self.count]


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
    unit = UNIT[precision]
    truth, signatures = perturbed(scene, method, 0.0, seed=0)
    response = np.zeros(truth.t.shape)
    risk = np.zeros(truth.t.shape, np.uint8)
    for k in range(probes):
        probe, others = perturbed(scene, method, unit, seed=k + 1)
        response = np.fmax(response, np.abs(probe.color - truth.color).max(axis=-1))
        for kind, signature in others.items():
            risk |= np.where((signature != signatures[kind]).reshape(risk.shape), kind, 0).astype(np.uint8)
        progress((k + 1) / probes)
    # an edge that a few probes never crossed in this pixel may be crossed in it by another: the neighbours know of it
    bound = SAFETY * _largest_around(response) + FLOOR_UNITS * unit * (1 + np.abs(truth.color).max(axis=-1))
    return Sensitivity(bound, risk, precision, truth)


def perturbed(scene: Scene, method: str, unit: float, seed: int) -> tuple[Picture, dict[int, np.ndarray]]:
    """The picture with every ray moved by multiples of `unit`, and for each risk a signature of every pixel's history."""
    watch = Perturbation(unit, seed, scene.camera.width * scene.camera.height)
    return render(scene, method, watch=watch), watch.signatures


def _largest_around(plane: np.ndarray) -> np.ndarray:
    h, w = plane.shape
    padded = np.pad(plane, 1, mode="edge")
    return np.maximum.reduce([padded[i:i + h, j:j + w] for i in range(3) for j in range(3)])
