"""Sections 4.3.2 and 4.3.3: the directions of reflection and refraction rays."""

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
