"""Whether a picture is right, pixel by pixel, and how far rounding may move a right answer.

The truth is that of the exact ray. A method computes in doubles, so that its answer is right if it is the exact one of a
ray within NEARBY units of rounding of it (backward error; Higham 2002, Accuracy and Stability of Numerical Algorithms,
section 1.5) - but which of two objects comes first must be exact or undecided (decision M4). Distances may be off by
SPARE times what one evaluation of f in doubles may hide, the radius of f in ball arithmetic of 53 bits over its slope.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from random import Random

import numpy as np
from flint import arb, fmpq

from .oracle import BITS, NOTHING, Hit, NotDefined, Oracle, Ray, Unsettled, along, dot, points, precision, rational

UNDECIDED = 2  # of the status plane
EPSILON = 2.0**-52
NEARBY = 4  # units of rounding
SPARE = 8
TRIES = 6  # rays nearby
SAME_COLOR = 1e-10  # relative to the brightest light


@dataclass
class Wrong:
    """One decided pixel that is wrong."""

    row: int
    column: int
    what: str  # "hit", "object", "distance", "normal", "color", "ray", "undefined"
    text: str


@dataclass
class Judgement:
    """What became of the judged pixels of one picture."""

    pixels: int = 0
    hits: int = 0  # that the oracle knows of
    undecided_hits: int = 0  # of those
    avoidable_hits: int = 0  # of those the ones whose colour the oracle knows
    unsettled: Counter = field(default_factory=Counter)  # reason -> pixels that the oracle cannot tell
    rounding: int = 0  # pixels that a nudge of the ray decides
    wrong: list[Wrong] = field(default_factory=list)


class Judge:
    """Holds pictures of one scene (a dictionary as its file has it) against the oracle."""

    def __init__(self, scene: dict, seed: int = 0):
        self.oracle, self.random = Oracle(scene), Random(seed)
        self.tolerance = 8 * 2.0**-52  # of the last step of a root search (decision M6), relative to max(1, t): that of `exact`
        brightest = sum(max(light.get("brightness", (1, 1, 1))) for light in scene.get("lights", ()))
        brightest += scene.get("tracing", {}).get("ambient", 0)
        self.brightest = max(brightest, max(scene.get("background", (0,))), 1e-300)
        far = lambda v: max(abs(float(c)) for c in v)
        self.reach = far(scene["camera"].get("position", (0,))) + max(
            far(o["surface"].get("center", (0,))) for o in scene["objects"])

    @precision()
    def judge(self, picture, pixels: list[tuple[int, int]]) -> Judgement:
        """`picture` has the planes of reference_tracer.tracer.render.Picture; `pixels` are (row, column)."""
        found = Judgement()
        for row, column in pixels:
            self._pixel(found, picture, row, column)
        return found

    @precision()
    def judge_literal(self, picture, pixels: list[tuple[int, int]]) -> Judgement:
        """A picture by the literal method: hits, distances and normals of single objects, where its steps and Newton's
        iterations leave no choice."""
        found = Judgement()
        self.tolerance = self.oracle.tolerance
        sharp = len(self.oracle.solids) == 1 and self.oracle.solids[0].formula.is_moderate
        for row, column in pixels if sharp else ():
            found.pixels += 1
            blame = lambda what, text: found.wrong.append(Wrong(row, column, what, text))
            try:
                ray = self.oracle.camera_ray(row, column)
                hit = self.oracle.literal_hit(ray)
            except Unsettled as reason:
                found.unsettled[str(reason)] += 1
                continue
            index = int(picture.index[row, column])
            found.hits += hit.index != NOTHING
            if index != hit.index:
                blame("hit", f"object {index} in place of {hit.index}")
            elif index != NOTHING:
                self._geometry(blame, picture, row, column, ray, hit)
        return found

    def _pixel(self, found: Judgement, picture, row: int, column: int) -> None:
        found.pixels += 1
        blame = lambda what, text: found.wrong.append(Wrong(row, column, what, text))
        index, undecided = int(picture.index[row, column]), picture.status[row, column] == UNDECIDED
        try:
            ray = self.oracle.camera_ray(row, column)
            hit = self.oracle.first_hit(ray)
        except Unsettled as reason:
            found.unsettled[str(reason)] += 1
            if not undecided and isinstance(reason, NotDefined):
                blame("undefined", f"decided, object {index}, though {reason}")
            return
        found.hits += hit.index != NOTHING
        if undecided:
            found.undecided_hits += hit.index != NOTHING
            found.avoidable_hits += hit.index != NOTHING and not hit.rivals and self._color(ray) is not None
            return
        if hit.rivals:
            blame("object", f"decided for object {index}, though objects {hit.index} and {hit.rivals} are at one distance")
            return
        if index != hit.index:
            if NOTHING in (index, hit.index) and any(
                    self._nearby_answers(ray, lambda r: self.oracle.first_hit(r).index == index)):
                found.rounding += 1
            else:
                blame("object" if NOTHING not in (index, hit.index) else "hit",
                      f"object {index} in place of {hit.index}"
                      + (f" at t = {float(hit.t):.17g}, gap {hit.gap:.1e}" if hit.t is not None else ""))
            return
        if index != NOTHING and not self._geometry(blame, picture, row, column, ray, hit):
            return
        self._judge_color(found, blame, picture.color[row, column], ray)

    # --- geometry --------------------------------------------------------------------------------------------------
    def _geometry(self, blame, picture, row: int, column: int, ray: Ray, hit: Hit) -> bool:
        t, exact = float(picture.t[row, column]), hit.t.mid().fmpq()
        if not math.isfinite(t):
            blame("distance", f"t = {t}")
            return False
        off = abs(rational(t) - exact)
        allowed = self._allowed_distance(ray, hit, rational(t))
        if off > allowed:
            blame("distance", f"t = {t:.17g}, exactly {float(hit.t):.17g}, off {float(arb(off)):.1e}, "
                              f"allowed {float(arb(allowed)):.1e}")
            return False
        reach = rational(EPSILON * SPARE) * rational(self.reach + t)
        position = [rational(float(c)) for c in picture.position[row, column]]
        exact_position = along(ray.o, ray.d, exact)
        apart = max(abs(p - q) for p, q in zip(position, exact_position))
        if apart > reach + off:
            blame("position", f"{[float(c) for c in picture.position[row, column]]}, off {float(arb(apart)):.1e}")
            return False
        try:
            normal = self.oracle.normal_at(ray, hit)
        except Unsettled:
            return True
        own = [float(c) for c in picture.normal[row, column]]
        angle = max(abs(float((arb(c) - n).mid())) for c, n in zip(own, normal)) if all(map(math.isfinite, own)) else math.inf
        if angle > 1e-12 and angle > (limit := self._allowed_angle(ray, hit, reach + off)):
            blame("normal", f"{own}, exactly {[float(n) for n in normal]}, off {angle:.1e}, allowed {limit:.1e}")
            return False
        return True

    def _allowed_distance(self, ray: Ray, hit: Hit, t: fmpq) -> fmpq:
        """How far rounding may move a hit: what one evaluation in doubles hides of f, over its slope.

        At a root without a slope, or where rounding hides f far about, the place is right if f is hidden there too.
        """
        unit = rational(EPSILON * (self.reach + float(hit.t)))
        floor = SPARE * unit + rational(self.tolerance * max(1.0, float(hit.t)))
        solid = self.oracle.solids[hit.index]
        radius, slope = self._hidden(solid, ray, hit.t.mid().fmpq(), unit)
        if radius is None:
            return max(floor, abs(t - hit.t.mid().fmpq()))  # nothing is known of rounding: the sign was right
        lowest = slope.abs_lower()
        if lowest > 0:
            floor = max(floor, rational((SPARE * radius / lowest).upper()))
        off = abs(t - hit.t.mid().fmpq())
        if off > floor and off < rational(1e-3) * t:
            there, _ = self._hidden(solid, ray, t, unit)
            value = abs(solid.value(points(along(ray.o, ray.d, t))))
            if there is not None and value < SPARE * there:
                return off
        return floor

    def _hidden(self, solid, ray: Ray, t: fmpq, unit: fmpq):
        """The radius of f and the slope of f along the ray, with 53 bits, for coordinates off by `unit`."""
        o, d = solid.into(along(ray.o, ray.d, t)), solid.into(ray.d, is_direction=True)
        with precision(53):
            try:
                blurred = tuple(arb(c, arb(unit)) for c in map(arb, o))
                s = solid.along(blurred, d, arb(0))
            except Unsettled:
                return None, None
        return (s.value.rad(), s.slope) if s.value.is_finite() and s.slope.is_finite() else (None, None)

    def _allowed_angle(self, ray: Ray, hit: Hit, reach: fmpq) -> float:
        """How far the normal turns within `reach` of the hit, and what rounding hides of the gradient."""
        solid, t = self.oracle.solids[hit.index], hit.t.mid().fmpq()
        normal, most = self.oracle.normal_at(ray, hit), 0.0
        with precision(4 * BITS):
            point = along(ray.o, ray.d, t)
            for k in range(3):
                for sign in (-1, 1):
                    moved = tuple(c + sign * reach * (j == k) for j, c in enumerate(point))
                    try:
                        there = solid.normal(moved)
                    except Unsettled:
                        continue
                    straight = 1 if dot(there, normal) > 0 else -1
                    most = max(most, *(abs(float((straight * a - b).mid())) for a, b in zip(there, normal)))
        return SPARE * most + self._hidden_of_gradient(solid, point, reach) + 1e-12

    def _hidden_of_gradient(self, solid, point, reach: fmpq) -> float:
        local = solid.into(point)
        try:
            with precision(53):
                slopes = solid.gradient(tuple(arb(c, arb(reach)) for c in map(arb, local)))
        except Unsettled:
            return math.inf
        if not all(s.is_finite() for s in slopes):
            return math.inf
        size = max(abs(s).lower() for s in slopes)
        share = (sum(s.rad() for s in slopes) / size).upper() if size > 0 else arb("inf")
        # at a multiple root the gradient as written vanishes and that of the surface does not
        return SPARE * float(share) if share < 1 else 1e-6

    # --- colour ----------------------------------------------------------------------------------------------------
    def _color(self, ray: Ray) -> list[float] | None:
        """The exact colour, None where the oracle cannot tell."""
        try:
            return [float(c.mid()) for c in self.oracle.color(ray)]
        except Unsettled:
            return None

    def _judge_color(self, found: Judgement, blame, color: np.ndarray, ray: Ray) -> None:
        try:
            exact = [float(c.mid()) for c in self.oracle.color(ray)]
        except Unsettled as reason:
            found.unsettled[f"secondary rays: {reason}"] += 1
            return
        off = self._off(color, exact)
        if off <= SAME_COLOR:
            return
        nearby = [c for c in (self._color(r) for r in self._nearby(ray)) if c is not None]
        spread = max((self._off(np.array(c), exact) for c in nearby), default=0.0)
        if off <= SPARE * spread or any(self._off(color, c) <= SAME_COLOR for c in nearby):
            found.rounding += 1
            return
        blame("color", f"{[float(c) for c in color]}, exactly {exact}, off {off:.1e}, rays nearby {spread:.1e}")

    def _off(self, color, exact) -> float:
        off = float(np.max(np.abs(np.asarray(color) - np.asarray(exact)))) / self.brightest
        return off if off == off else math.inf

    # --- rays nearby -----------------------------------------------------------------------------------------------
    def _nearby(self, ray: Ray):
        """Rays within NEARBY units of rounding of the exact one."""
        draw = lambda size: rational(self.random.uniform(-1, 1) * NEARBY * EPSILON * size)
        for _ in range(TRIES):
            yield Ray(tuple(c + draw(self.reach) for c in ray.o), tuple(c + draw(1.0) for c in ray.d), ray.inside,
                      ray.limit)

    def _nearby_answers(self, ray: Ray, holds):
        for near in self._nearby(ray):
            try:
                yield holds(near)
            except Unsettled:
                yield False
