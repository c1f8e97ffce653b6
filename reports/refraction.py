"""The misprint of section 4.3.3.2 (decision E1) as a chart: where each of the two formulas sends a ray."""

from __future__ import annotations

import math

from .axis import LinearAxis
from .numbers import Number
from .plot import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH, Curve, Plot, polyline

INDEX = 1.5  # of the glass a ray enters
STEP = 0.5  # degrees between points of a curve


def refracted(incidence: float, ratio: float) -> float | None:
    """The angle in degrees whose sine is `ratio` times that of `incidence`; None where no angle has that sine."""
    sine = ratio * math.sin(math.radians(incidence))
    return math.degrees(math.asin(sine)) if sine <= 1 else None


def printed_direction(incidence: float, index: float = INDEX) -> tuple[float, float]:
    """Length, and angle to the normal in degrees, of the refraction direction computed with the printed sine on entry.

    The direction formula below the misprint takes its tangential part from the incoming ray, times n1/n2, which is
    right; only its normal part, the cosine, comes from the printed sine. Needs an angle below `last_printed_angle`.
    """
    sine = math.sin(math.radians(incidence))
    along, down = sine / index, math.sqrt(1 - (sine * index) ** 2)
    return math.hypot(along, down), math.degrees(math.atan2(along, down))


def last_printed_angle(index: float = INDEX) -> float:
    """The angle of incidence, in degrees, from which on the printed sine exceeds 1 on entry."""
    return math.degrees(math.asin(1 / index))


def refraction_plot() -> Plot:
    """The angle of refraction over the angle of incidence, on entry from air into glass."""
    x_axis, y_axis = LinearAxis(90, LEFT, WIDTH - RIGHT), LinearAxis(90, HEIGHT - BOTTOM, TOP)
    angles = [k * STEP for k in range(int(90 / STEP) + 1)]
    last = last_printed_angle()
    below = [a for a in angles if a < last]
    formulas = (("the law, n1/n2", 1 / INDEX, angles),
                ("the sine as printed, n2/n1", INDEX, below))
    curves = []
    for style, (label, ratio, domain) in enumerate(formulas):
        points = [(x_axis.at(a), y_axis.at(refracted(a, ratio))) for a in domain]
        if ratio > 1:  # ends where the sine is 1
            points.append((x_axis.at(last), y_axis.at(90)))
        curves.append(Curve(label, style, polyline(points)))
    curves.append(Curve("the direction a program then computes", 2, polyline(
        [(x_axis.at(a), y_axis.at(printed_direction(a)[1])) for a in below] + [(x_axis.at(last), y_axis.at(90))])))
    straight = Curve("no refraction", 5, polyline([(x_axis.at(a), y_axis.at(a)) for a in (0, 90)]))
    degrees = lambda value: Number(f"{value:.0f}°")
    return Plot("refraction", "Angle of refraction over angle of incidence by both formulas",
                f"angle of incidence, from air into n = {INDEX:g}", "angle of refraction",
                x_axis.ticks(15, degrees), y_axis.ticks(15, degrees), (*curves, straight))
