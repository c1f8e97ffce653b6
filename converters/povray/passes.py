"""What POV-Ray is made to show instead of colours, so that its picture tells geometry: materials that glow by themselves.

One picture has three channels of 16 bits. A distance takes all three, the most significant digits first.
"""

from __future__ import annotations

import numpy as np

from .words import number, vector

STEPS = 65535  # of a channel
GLOWING = "finish { emission 1 }"


def object_number(index: int) -> str:
    """The number of the object, from 1 on, in the red channel."""
    return f"pigment {{ rgb {vector([(index + 1) / STEPS, 0, 0])} }} {GLOWING}"


def numbers_of(picture: np.ndarray) -> np.ndarray:
    """(h, w) int32 from the channels (h, w, 3): the object's index in scene order, -1 where there is none."""
    return picture[..., 0].astype(np.int32) - 1


def declare_distance(origin, end: float) -> str:
    """The pigment `Distance`: distance from `origin` as a fraction of `end`, in base 65535. Place it in world space."""
    square = "+".join(f"pow({axis}-({number(o)}),2)" for axis, o in zip("xyz", origin))
    # each digit is a step of its colour map: a quarter more keeps it on its own side of rounding
    digit = lambda k, color: (f"[1 function {{ (Digit{k}(x,y,z)+0.25)/{STEPS} }} "
                              f"color_map {{ [0 rgb 0][1 rgb 3*{vector(color)}] }}]")
    return (f"#declare Digits1 = function {{ sqrt({square})/{number(end)}*{STEPS} }};\n"
            "#declare Digit1 = function { floor(Digits1(x,y,z)) };\n"
            f"#declare Digits2 = function {{ (Digits1(x,y,z)-Digit1(x,y,z))*{STEPS} }};\n"
            "#declare Digit2 = function { floor(Digits2(x,y,z)) };\n"
            f"#declare Digit3 = function {{ floor((Digits2(x,y,z)-Digit2(x,y,z))*{STEPS}) }};\n"
            "#declare Distance = pigment { average pigment_map { "
            f"{digit(1, (1, 0, 0))} {digit(2, (0, 1, 0))} {digit(3, (0, 0, 1))} }} }}")


DISTANCE = f"pigment {{ Distance }} {GLOWING}"


def distances_of(picture: np.ndarray, end: float) -> np.ndarray:
    """(h, w) distances in units of `end`, from the channels (h, w, 3)."""
    high, middle, low = (picture[..., k].astype(float) for k in range(3))
    return (high + (middle + (low + 0.5) / STEPS) / STEPS) / STEPS * end


NORMAL = ("pigment { average pigment_map { "
          + " ".join(f"[1 slope {axis} color_map {{ [0 rgb 0][1 rgb 3*{axis}] }}]" for axis in "xyz")
          + f" }} }} {GLOWING}")


def normals_of(picture: np.ndarray) -> np.ndarray:
    """(h, w, 3) unit vectors from the channels (h, w, 3): each is 1 - angle / pi between normal and axis."""
    cosines = np.cos(np.pi * (1 - picture / STEPS))
    return cosines / np.linalg.norm(cosines, axis=-1, keepdims=True)
