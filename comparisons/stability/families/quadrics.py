"""Families of quadrics: one ball, a cone, concentric spheres, and rays that start on a surface."""

from __future__ import annotations

import math

import numpy as np

from raytruth.reference_tracer.surfaces.outside import BOX_MARGIN

from ..document import MOST_EVALUATIONS
from ..exact import ball_crossings, crossings, rational
from ..family import About, Draw, Law, Rays, Shape, SurfaceFamily, unit
from ..methods import SIDE_FROM_SIGN, offset

STEP = 0.05


def _box(center_x, r, scale):
    r = r * (1 + BOX_MARGIN)
    return (center_x - r, -r, -r), (center_x + r, r, r)


def _f(x, y, z, center_x, r, scale):
    return ((x - center_x) ** 2 + y**2 + z**2 - r * r) * scale


BALL = Shape(_f, degree=2, box=_box)
FORMULA = Shape(_f, degree=2)  # as a user types it, without a box


def _rays(draw: Draw, impact, *, distance=3.0, r=1.0, center_x=0.0, scale=1.0, step=STEP, **more) -> Rays:
    """Rays that pass the centre of a ball at `impact`, from `distance` before it, with the exact answer."""
    o, d = draw.lines(impact, distance, jitter=6 * step)
    r, center_x, scale = (float(draw.stored(v)) for v in (r, center_x, scale))
    o[:, 0] = draw.stored(o[:, 0] + center_x)
    roots = ball_crossings(o, d, [center_x] * len(o), [rational(r) * rational(r)] * len(o))
    ahead = np.where(roots > 0, roots, np.inf)
    settings = {"limit": 2 * distance, "accuracy": 1e-3 if draw.single else 1e-6, "step": step} | more
    return Rays.of(o, d, first=ahead[:, 0], others=roots[:, 1:], center_x=center_x, r=r, scale=scale, **settings)


def _anywhere(draw: Draw, r: float = 1.0):
    """Impact parameters well within a ball of radius r."""
    return draw.uniform(0, 0.9 * r)


def grazing_rate(p: float) -> float | None:
    """1 - chord/h: the chord has length 2 sqrt(1 - (1 - p)^2), the phase of the steps is uniform.

    Newton on the parabola g, from a middle that lies before its vertex, converges to the first root; it does lie there.
    """
    if p < 1e-12:
        return None  # the rounding of the rays themselves decides which of them touch
    return max(0.0, 1 - 2 * math.sqrt(2 * p - p * p) / STEP)


def small_ball_rate(r: float) -> float:
    """Chords 2 r s with s = sqrt(1 - U), U uniform, density 2 s: the mean of max(0, 1 - chord/h)."""
    ratio = 2 * r / STEP
    return 1 - 2 / 3 * ratio if ratio <= 1 else 1 / (3 * ratio**2)


_LONG_CHORDS = Law("paper", "0: chords are longer than the step, Newton uses quotients of f only", lambda p: 0.0)


# --- almost linear along the ray --------------------------------------------------------------------------------------
CONE_LIMIT = 30.0
CONE = Shape(lambda x, y, z: x**2 + y**2 - z**2, degree=2)


def _along_generator(angle: float, draw: Draw) -> Rays:
    """Rays at `angle` to a generator of the double cone, from points around its tip.

    Where they are parallel, t^2 has the coefficient zero, or what rounding makes of it: the second root is at infinity.
    """
    turn = draw.uniform(0, 2 * math.pi)
    generator = np.column_stack([np.cos(turn), np.sin(turn), np.ones(draw.count)]) / math.sqrt(2)
    aside = unit(np.cross(generator, draw.directions()))
    o = draw.stored(draw.uniform(-2, 2, (3,)))
    d = draw.stored(unit(math.cos(angle) * generator + math.sin(angle) * aside))
    roots = [crossings(CONE.f, a, b, math.inf) for a, b in zip(o, d)]
    table = np.array([t + [np.inf] * (2 - len(t)) for t in roots])
    x, y, z = ([rational(v) for v in column] for column in o.T)
    inside = [a * a + b * b < c * c for a, b, c in zip(x, y, z)]
    first = np.where(table[:, 0] <= CONE_LIMIT, table[:, 0], np.inf)
    return Rays.of(o, d, inside=inside, first=first, others=table[:, 1:], limit=CONE_LIMIT,
                   accuracy=(1e-3 if draw.single else 1e-6) * CONE_LIMIT)


# --- q^2 - c with q = x^2 + y^2 + z^2 - 1: walls, near zeros and even roots -------------------------------------------
START = 3.0
WIDEST_IMPACT = 0.7

SHELL = Shape(lambda x, y, z, c: (x**2 + y**2 + z**2 - 1) ** 2 - c, degree=4)


def _shell(p: float, draw: Draw, step: float = STEP) -> Rays:
    """|q| = p: two concentric spheres, of radius sqrt(1 + p) and sqrt(1 - p)."""
    p = float(draw.stored(p))
    o, d = draw.lines(draw.uniform(0, WIDEST_IMPACT), START, jitter=6 * STEP)
    zeros, level = np.zeros(len(o)), rational(p)
    outer, inner = (ball_crossings(o, d, zeros, [1 + sign * level] * len(o)) for sign in (1, -1))
    # a tenth of the wall, unless the condition of the root, eps / |g'|, is worse
    accuracy = min(1e-3, max(p / 10, 1e-6 / p)) if draw.single else min(1e-6, max(p / 10, 1e-15 / p))
    return Rays.of(o, d, first=outer[:, 0], others=np.column_stack([inner, outer[:, 1]]), accuracy=accuracy, step=step,
                   c=draw.stored(p * p))


def shell_rate(p: float) -> float | None:
    """1 - w/h, averaged over impact parameters b uniform in [0, B]; w = sqrt(1 + p - b^2) - sqrt(1 - p - b^2).

    The first wall is found if a sample falls into it; from there Newton converges to its outer face as long as w < h,
    because q^2 - p^2 is convex in q and the middle of the step lies outside or in the outer half of the wall.
    """
    area = lambda square: 0.5 * (B * math.sqrt(square - B * B) + square * math.asin(B / math.sqrt(square)))
    B = WIDEST_IMPACT
    widest = math.sqrt(1 + p - B * B) - math.sqrt(1 - p - B * B)
    return None if widest > STEP else 1 - (area(1 + p) - area(1 - p)) / (B * STEP)


def fine_steps_rate(p: float) -> float | None:
    """The wall lies 1.7 to 2.3 away, so 3.4/p to 4.6/p steps of p/2 are needed, and at most 40 evaluations more."""
    return 1.0 if 3.4 / p > MOST_EVALUATIONS else 0.0 if 4.6 / p + 40 < MOST_EVALUATIONS else None


def _never_zero(p: float, draw: Draw) -> Rays:
    o, d = draw.lines(draw.uniform(0, 0.9), 3.0, jitter=6 * STEP)
    return Rays.of(o, d, first=np.inf, step=STEP, c=-draw.stored(p * p))


def _even_root(p: float, draw: Draw) -> Rays:
    """q^2 touches zero where the ray meets the unit sphere, and never changes sign (decision M1)."""
    o, d = draw.lines(np.full(draw.count, 1 - p), 3.0, jitter=6 * STEP)
    touching = ball_crossings(o, d, np.zeros(len(o)), [rational(1.0)] * len(o))
    return Rays.of(o, d, first=np.inf, others=touching, step=STEP, c=0.0)


# --- rays that start on the surface: on which side are they? ----------------------------------------------------------
EPSILONS = (1e-2, 1e-4, 1e-6)


def _from_the_surface(angle: float, draw: Draw) -> Rays:
    """Origins that miss the unit sphere by noise; every other ray goes in and crosses the ball, the rest leave.

    The noise stays a hundredth of what would lift a ray that goes in off the ball altogether, sin^2(angle) / 2.
    """
    normal = draw.directions()
    tangent = unit(np.cross(normal, draw.directions()))
    inwards = np.arange(draw.count) % 2 == 1
    noise = min(1e-12, 5e-3 * math.sin(angle) ** 2) if not draw.single else 1e-7
    o = draw.stored(normal * (1 + noise * draw.uniform(-1, 1)[:, None]))
    rise = np.where(inwards, -1.0, 1.0)[:, None] * math.sin(angle)
    d = draw.stored(unit(math.cos(angle) * tangent + rise * normal))
    roots = ball_crossings(o, d, np.zeros(len(o)), [rational(1.0)] * len(o))
    # going out: both crossings are the noise at the origin, or behind it
    first = np.where(inwards, roots[:, 1], np.inf)
    accuracy = max((1e-2 if draw.single else 1e-3) * 2 * math.sin(angle), 1e-12)
    return Rays.of(o, d, inside=inwards, limit=3.0, first=first, others=roots[:, :1], accuracy=accuracy, step=STEP,
                   center_x=0.0, r=1.0, scale=1.0)


def _offset_law(epsilon: float) -> Law:
    rate = lambda p: 0.5 if epsilon > 2 * math.sin(p) else 0.0
    return Law(offset(epsilon).name, f"1/2 where the chord 2 sin(p) is shorter than {epsilon:g}, else 0", rate)


FAMILIES = (
    SurfaceFamily(
        About("grazing", "Grazing a ball", "1 - impact parameter",
              (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16),
              when="A ray cuts the ball in a chord that is shorter than the step.",
              why="Both crossings fall between two samples, which then have the same sign. Below 1e-14 the rounding of "
                  "f is as large as what it has to resolve.",
              instead="A closed form, Descartes' rule or intervals; a proof says where fp64 cannot tell.",
              single=(1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)),
        BALL, lambda p, draw: _rays(draw, np.full(draw.count, 1 - p)),
        laws=(Law("paper", "1 - chord/h with chord = 2 sqrt(1 - (1 - p)^2)", grazing_rate),)),
    SurfaceFamily(
        About("near-miss", "Just missing a ball", "impact parameter - 1", (1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 1e-15),
              when="A ray passes the ball at a distance near the rounding of f.",
              why="g comes as close to zero as its own rounding error, and may change sign by it.",
              instead="Proofs: they answer \"undecided\" instead of guessing.",
              single=(1e-3, 1e-4, 1e-5, 1e-6, 1e-7)),
        BALL, lambda p, draw: _rays(draw, np.full(draw.count, 1 + p))),
    SurfaceFamily(
        About("small-ball", "A small ball", "radius", (1.0, 0.1, 0.05, 0.025, 0.01, 1e-3, 1e-4, 1e-6),
              when="The solid is smaller than the step.", why="No sample falls inside it.",
              instead="Any method that does not sample; else a step below the size of the smallest detail.",
              single=(1.0, 0.1, 0.025, 0.01, 1e-3)),
        BALL, lambda p, draw: _rays(draw, p * np.sqrt(draw.uniform(0, 1)), r=p,
                                    accuracy=(1e-3 if draw.single else 1e-6) * max(p, 1e-3)),
        laws=(Law("paper", "1 - 4 r / (3 h) for r <= h/2, (h / 2 r)^2 / 3 above: the mean over the ball's disc",
                  small_ball_rate),)),
    SurfaceFamily(
        About("camera-distance", "A camera far away", "distance of the camera", (1e1, 1e2, 1e4, 1e6, 1e8),
              when="The camera is so far away that the rounding of its coordinates reaches the accuracy asked for.",
              why="A point at distance R is rounded by 1e-16 R (fp64) or 6e-8 R (fp32); no method undoes that.",
              instead="Double precision, and a camera within 1e8 times the smallest detail.",
              single=(1e1, 1e2, 1e3, 1e4)),
        BALL, lambda p, draw: _rays(draw, _anywhere(draw), distance=p), laws=(_LONG_CHORDS,)),
    SurfaceFamily(
        About("translated", "f written far from its origin", "distance of the ball from the origin of f",
              (1e1, 1e2, 1e4, 1e6, 1e8),
              when="f holds an offset, as in (x - 10000)^2, that is large against the solid.",
              why="x - R loses the digits of x below 1e-16 R, and so does every point on the ray.",
              instead="Give the object a \"center\": it is subtracted once, from the ray.",
              single=(1e1, 1e2, 1e3, 1e4)),
        FORMULA, lambda p, draw: _rays(draw, _anywhere(draw), center_x=p), laws=(_LONG_CHORDS,)),
    SurfaceFamily(
        About("scaled-scene", "The whole scene scaled", "factor on all lengths, the step included",
              (1.0, 1e3, 1e6, 1e-3, 1e-6, 1e-9),
              when="A scene is so small that tolerances meant for lengths near 1 exceed its details.",
              why="Newton stops at |dt| <= tol max(1, |t|): for a scene of size 1e-9 that is coarse.",
              instead="Build scenes with lengths near 1.", single=(1.0, 1e3, 1e-3, 1e-4)),
        BALL, lambda p, draw: _rays(draw, _anywhere(draw, p), r=p, distance=3 * p, step=STEP * p,
                                    accuracy=(1e-3 if draw.single else 1e-6) * p)),
    SurfaceFamily(
        About("scaled-f", "f multiplied by a constant", "factor",
              (1.0, 1e6, 1e-6, 1e12, 1e-12, 1e100, 1e-100, 1e200, 1e-200),
              when="Products of coefficients overflow or underflow.",
              why="f and 1e200 f have the same zeros, but squares of the coefficients of the latter are infinite.",
              instead="Methods that use only signs and quotients of f, or coefficients divided by the largest.",
              single=(1.0, 1e6, 1e-6, 1e12, 1e-12, 1e25, 1e-25)),
        FORMULA, lambda p, draw: _rays(draw, _anywhere(draw), scale=p), laws=(_LONG_CHORDS,)),
    SurfaceFamily(
        About("asymptote", "Along a generator of a cone", "angle between ray and generator, radians",
              (1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0),
              when="A ray is almost parallel to a straight line of a quadric.",
              why="The coefficient of t^2 is rounding noise: dividing by it, or trusting its sign, makes up a root.",
              instead="The formula without cancellation, and the side the ray is on to choose the root.",
              single=(1e-1, 1e-3, 1e-6, 0.0)),
        CONE, _along_generator),
    SurfaceFamily(
        About("thin-shell", "A thin shell", "p in |x^2 + y^2 + z^2 - 1| = p, the thickness of the wall",
              (0.03, 0.01, 1e-3, 1e-4, 1e-6, 1e-8),
              when="A wall is thinner than the step.",
              why="The samples before and behind the wall have the same sign; the far side of the shell is seen.",
              instead="Descartes' rule or intervals; steps below the thickness are slow.",
              single=(0.03, 0.01, 1e-3, 1e-4)),
        SHELL, _shell, laws=(Law("paper", "1 - mean(w)/h with w the wall's length along the ray, where w < h",
                                 shell_rate),)),
    SurfaceFamily(
        About("fine-steps", "A thin shell, steps of half its thickness", "thickness of the wall",
              (0.03, 0.01, 1e-3, 5e-4, 1e-4),
              when="Steps are made as small as the finest detail, so that none is missed.",
              why="The number of steps grows as 1/p, for every ray, whether it meets the detail or not.",
              instead="Descartes' rule or intervals: their steps adapt to the ray."),
        SHELL, lambda p, draw: _shell(p, draw, step=p / 2),
        laws=(Law("paper", f"more than {MOST_EVALUATIONS} evaluations a ray as soon as 3.4/p is more", fine_steps_rate,
                  kinds=("too slow",)),
              Law("paper", "0: every wall is met by a sample, and by its outer half", lambda p: 0.0))),
    SurfaceFamily(
        About("never-zero", "Almost zero, everywhere on a sphere", "p in (x^2 + y^2 + z^2 - 1)^2 + p^2",
              (1e-1, 1e-2, 1e-4, 1e-6, 1e-7, 1e-8),
              when="A double root has just been lifted off zero, by less than coefficients resolve.",
              why="The coefficients of the ray's polynomial are rounded by 1e-16 of the largest: p^2 drowns in that.",
              instead="Evaluate f itself, or intervals; take the polynomial's answer only where its noise allows.",
              single=(1e-1, 1e-2, 1e-3, 1e-4)),
        SHELL, _never_zero),
    SurfaceFamily(
        About("even-root", "A surface that only touches zero", "1 - impact parameter on (x^2 + y^2 + z^2 - 1)^2",
              (0.9, 0.5, 0.1, 1e-2, 1e-4),
              when="f does not change sign at its surface.",
              why="By decision M1 a hit is a change of sign: the surface is invisible, which is right here and "
                  "surprising to whoever typed the formula.",
              instead="Write a formula that changes sign. Methods say \"undecided\" where rounding hides the sign."),
        SHELL, _even_root,
        laws=(Law("paper", "1: no ray ever reports the surface it meets", lambda p: 1.0, kinds=("correct",)),)))

SECONDARY = (
    SurfaceFamily(
        About("secondary-rays", "Secondary rays at grazing angles", "angle between the ray and the surface, radians",
              (0.5, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6),
              when="A ray starts on a surface and the side it is on is guessed.",
              why="f at its origin is rounding noise, so half of the guesses are wrong; an offset along the ray is "
                  "wrong as soon as the ray leaves the solid again within it.",
              instead="Inherit the side from the parent ray (decision M3): no epsilon, no failure at any angle.",
              single=(0.5, 0.1, 1e-2)),
        BALL, _from_the_surface, variants=(SIDE_FROM_SIGN, *map(offset, EPSILONS)),
        laws=(Law("paper", "0: the side is inherited", lambda p: 0.0),
              Law(SIDE_FROM_SIGN.name, "1/2: the sign of noise", lambda p: 0.5), *map(_offset_law, EPSILONS))),)
