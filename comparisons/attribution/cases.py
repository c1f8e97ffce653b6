"""Wrong on purpose: tracers that differ from the reference in one formula.

What notices differences has to be shown differences. Each fault is a slip that a port of the document may make, the
scene of one effect on which it shows, and the stage that must be named for it. It is a tracer of its own: a World with
another query, or with another of the formulas in `Optics`.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from raytruth.reference_tracer.tracer.optics import Optics, Refraction
from raytruth.reference_tracer.tracer.world import World

from ..suites import choose
from .document import Stage


@dataclass(frozen=True)
class Fault:
    """`right` is the formula, `wrong` what `world` computes; `effect` is the scene of one effect on which it shows."""

    id: str
    title: str
    world: type[World]
    right: str
    wrong: str
    effect: str
    stage: Stage
    because: str


class RowsFromTheBottom(World):
    def camera_ray(self, row, column, sample_row, sample_column, samples):
        last = self.scene.camera.height - 1
        return super().camera_ray(last - row, column, samples - 1 - sample_row, sample_column, samples)


class ShortRange(World):
    def __init__(self, scene, method, arrays):
        super().__init__(scene, method, arrays)
        self.max_distance = arrays.constant(0.2 * scene.tracing.max_distance)


class OneDecimal(World):
    def nearest(self, ray):
        hit = super().nearest(ray)
        hit.t = dr.round(hit.t * 10) / 10
        return hit


class NotTurned(Optics):
    def facing(self, d, gradient):
        return gradient, dr.abs(dr.dot(d, gradient))


class FallingOff(Optics):
    def light(self, cos, intensity, distance):
        return super().light(cos, intensity, distance) * 9 / (distance * distance)


class ShadowOnce(Optics):
    def attenuated(self, intensity, transparency, crossings):
        return dr.select(crossings > 0, intensity * transparency, intensity)


class ReflectedShort(Optics):
    def reflect(self, d, normal, cos1):
        return d + normal * cos1


class AsPrinted(Optics):
    def refract(self, d, normal, cos1, n1, n2, as_printed=False):
        sin2 = dr.sqrt(dr.maximum(1 - cos1 * cos1, 0)) * (n2 / n1)
        along = (d + normal * cos1) * (n1 / n2)
        return Refraction(along - normal * dr.sqrt(dr.maximum(1 - sin2 * sin2, 0)),
                          super().refract(d, normal, cos1, n1, n2).total)


class NeverTotal(Optics):
    def refract(self, d, normal, cos1, n1, n2, as_printed=False):
        right = super().refract(d, normal, cos1, n1, n2, as_printed)
        return Refraction(right.direction, dr.zeros(type(right.total)))


class NotDimmed(Optics):
    def own_weight(self, reflection, transparency):
        return 1.0 - transparency


class MeanOfN(Optics):
    def samples(self, n):
        return n


def _with(formulas: type[Optics]) -> type[World]:
    return type(formulas.__name__, (World,), {"optics": formulas()})


FAULTS = {f.id: f for f in (
    Fault("y-flipped", "rows counted from the bottom", RowsFromTheBottom, "row", "height - 1 - row", "effect-shading",
          "camera", "every ray goes through another pixel's place (section 2, decision C1)"),
    Fault("rays-end-early", "rays that end at a fifth of max_distance", ShortRange, "max_distance", "0.2 max_distance",
          "effect-shadow", "hit", "what lies beyond is not hit (section 4.1, decision M5)"),
    Fault("one-decimal", "roots found to one decimal", OneDecimal, "t", "round(10 t) / 10", "effect-shading", "root",
          "the right object is hit at the wrong distance: the iteration of section 4.2 ends too early"),
    Fault("normal-not-turned", "normals not turned against the ray", _with(NotTurned),
          "-gradient where cos1 < 0, else gradient", "gradient", "effect-refraction", "normal",
          "from within an object the gradient points along the ray (decision N1)"),
    Fault("falling-off", "light that falls off with the distance", _with(FallingOff), "cos intensity",
          "cos intensity 9 / distance²", "effect-shading", "shading",
          "illumination = cos(phi) brightness intensity knows no distance (section 4.3.1, decision L1)"),
    Fault("shadow-once", "transparency T instead of T² in shadows", _with(ShadowOnce), "intensity T^crossings",
          "intensity T", "effect-shadow", "shadow",
          "light is weakened at every crossing, so twice by a solid in its way (decision L3)"),
    Fault("reflected-short", "reflection direction without its factor 2", _with(ReflectedShort), "d + 2 cos1 normal",
          "d + cos1 normal", "effect-reflection", "reflection", "the ray leaves along the surface (section 4.3.2)"),
    Fault("as-printed", "the law of refraction as printed (E1)", _with(AsPrinted), "sin2 = sin1 n1 / n2",
          "sin2 = sin1 n2 / n1", "effect-refraction", "refraction",
          "the sine of the second angle is multiplied by n2/n1 instead of n1/n2 (section 4.3.3.2, decision E1)"),
    Fault("no-total-reflection", "total reflection left out", _with(NeverTotal), "total = sin1 > n2 / n1", "total = False",
          "effect-total-reflection", "refraction",
          "beyond the critical angle a ray leaves along the surface instead of bouncing (section 4.3.3.1)"),
    Fault("no-1-minus-r", "visible colour without its factor 1 − reflection", _with(NotDimmed), "(1 - R) (1 - T)", "1 - T",
          "effect-mixing", "mixing",
          "1 − reflection weighs the point's own colour in the sum of section 4.3.4: no ray is wrong, their sum is"),
    Fault("mean-of-n", "n × n samples divided by n", _with(MeanOfN), "sum / n²", "sum / n", "effect-multisampling",
          "sampling", "one sample a pixel is right, the mean of n × n is not (section 5)"),
)}


def fault(id: str) -> Fault:
    """The fault called `id`. Raises InputError."""
    return choose([id], FAULTS, "unknown fault")[0]
