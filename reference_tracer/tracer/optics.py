"""The formulas of section 4.3, apart from the tracing: light, secondary directions, weights."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr


@dataclass
class Refraction:
    """A refraction ray's direction, and where total internal reflection takes its place."""

    direction: object  # Vector
    total: object  # Bool


def reflect(d, normal, cos1):
    """r_dir - 2 normal (r_dir . normal), with cos1 = -r_dir . normal (section 4.3.2)."""
    return d + normal * (2 * cos1)


def refract(d, normal, cos1, n1, n2, as_printed: bool = False) -> Refraction:
    """The law of refraction from a medium of index n1 into one of n2 (section 4.3.3).

    `normal` is turned against the unit direction `d`, cos1 = -d . normal >= 0. Total internal reflection happens
    where sin1 > n2/n1; at equality the ray refracts (decision R2). `as_printed` takes sin2 = sin1 n2/n1, the misprint
    of section 4.3.3.2 (decision E1), instead of Snell's sin2 = sin1 n1/n2.
    """
    sin1 = dr.sqrt(dr.maximum(1 - cos1 * cos1, 0))
    total = sin1 > n2 / n1
    sin2 = sin1 * (n2 / n1 if as_printed else n1 / n2)
    cos2 = dr.sqrt(1 - sin2 * sin2) if as_printed else dr.sqrt(dr.maximum(1 - sin2 * sin2, 0))
    return Refraction((d + normal * cos1) * (n1 / n2) - normal * cos2, total)


class Optics:
    """The formulas by which a world is shaded, a method each: a tracer with another formula is a subclass of it."""

    reflect, refract = staticmethod(reflect), staticmethod(refract)

    def facing(self, d, gradient):
        """The unit normal, turned against the ray (decision N1), and cos(phi1) >= 0."""
        cos1 = -dr.dot(d, gradient)
        return dr.select(cos1 < 0, -gradient, gradient), dr.abs(cos1)

    def light(self, cos, intensity, distance):
        """The illumination per brightness from a light at `distance`, of which `intensity` arrives (L1, L2)."""
        return dr.select(intensity > 0, cos * intensity, 0)

    def combined(self, illumination, light, balanced: bool):
        """Illumination with one more light, per channel: the plain sum (L1), or 1 - (1 - I)(1 - light) (decision F1)."""
        return illumination + light * (1 - illumination) if balanced else illumination + light

    def attenuated(self, intensity, transparency, crossings):
        """What is left of `intensity` behind an object whose surface was crossed so often (decision L3)."""
        return _multiply_repeatedly(intensity, transparency, crossings)

    def own_weight(self, reflection, transparency):
        """The weight of a point's own colour in the sum of section 4.3.4."""
        return (1.0 - reflection) * (1.0 - transparency)

    def samples(self, n: int) -> int:
        """How many samples a pixel's colour is the mean of (section 5)."""
        return n * n


@dr.syntax
def _multiply_repeatedly(value, factor, times):
    while times > 0:
        value *= factor
        times -= 1
    return value
