"""Section 4.3.4 in POV-Ray's terms.

POV-Ray itself scales the diffuse part by 1 - T, but not the reflection. In total internal reflection it adds the
reflection with the weight of `refraction` and nothing else, where the document's weight is A = R (1 - T) + T (decision
R3). Hence refraction A and the transmittance T / A, whose product is T. That transmittance would be wrong in shadows,
so the body casts none; a twin in its place, seen by shadow rays alone, takes T of the light at each crossing (L3).
"""

from __future__ import annotations

import numpy as np

from raytruth.reference_tracer.scene.model import Material

from .words import number

MOST_TRANSMITTED = 1 - 2.0**-18  # the body must keep something to be lit by
LIT, GLOWING = "diffuse", "emission"  # what an object's own part of a colour comes from


def opaque(m: Material, own: str = LIT, ambient: float = 0.0) -> str:
    return (f"pigment {{ {_pigment(m, 0, own)} }} finish {{ {_own(own, 1 - m.reflection, ambient)} "
            f"reflection {{ {number(m.reflection)} }} }}")


def body(m: Material, ior: float, own: str = LIT, ambient: float = 0.0) -> str:
    """What camera, reflected and refracted rays see of a transparent object."""
    R, T = m.reflection, m.transparency
    weight = (1 - R) * (1 - T)
    transmitted = T / (R * (1 - T) + T)
    if weight:
        transmitted = min(transmitted, MOST_TRANSMITTED)
    transmitted = float(np.float32(transmitted))  # POV-Ray keeps colours in fp32
    if weight:
        weight /= 1 - transmitted
    return (f"pigment {{ {_pigment(m, transmitted, own)} }} finish {{ {_own(own, weight, ambient)} "
            f"reflection {{ {number(R * (1 - T))} }} refraction {number(T / transmitted)} }} "
            f"interior {{ ior {number(ior)} }} no_shadow")


def twin(m: Material) -> str:
    """What shadow rays see of a transparent object."""
    return f"pigment {{ rgbt <1,1,1,{number(m.transparency)}> }} no_image no_reflection"


def _own(own: str, weight: float, ambient: float) -> str:
    """An object's own part of a colour, of that weight; lit by `ambient` without any light (decision F2)."""
    return f"{own} {number(weight)}" + (f" {GLOWING} {number(weight * ambient)}" if ambient and own == LIT else "")


def _pigment(m: Material, transmitted: float, own: str) -> str:
    """The object's colour, or white where it glows: what is then seen is the weight of its colour in the pixel's."""
    color = m.color if own == LIT else (1.0, 1.0, 1.0)
    return f"rgbt <{','.join(map(number, (*color, transmitted)))}>"
