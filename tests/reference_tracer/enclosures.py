"""Every number type held against python-flint's balls on random arguments: `make enclosures`.

A function of an interval must hold the true value at every point of it, and so must its derivative by duals, whatever the
size of the arguments: ordinary, up to 1e308, down to 5e-324, zero, infinite. `Interval` is granted the rounding it states.
Prints, for each function and type, how many arguments were tried, how many true values lay outside (none may) and the median
width of the enclosure of a single point, in units in the last place; then how far functions of floats are off, next to what
interval.py grants them. Exit code 1 if anything lay outside.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_series

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.certify.search import precision
from raytruth.reference_tracer.numbers import composed
from raytruth.reference_tracer.numbers import functions as fn
from raytruth.reference_tracer.numbers import interval as stated
from raytruth.reference_tracer.numbers.dual import Dual
from raytruth.reference_tracer.numbers.exact import Series
from raytruth.reference_tracer.numbers.interval import Interval, OutwardInterval

BITS = 160  # of the true values
POINTS = 4  # tried in every interval: both ends, two within
SLOPES = (1.0, 0.5)  # derivatives of the first and the second argument
LARGEST = sys.float_info.max
SMALLEST_NORMAL = sys.float_info.min
FARTHEST = 1e5  # |log| of a value above which floats cannot tell it from
BEYOND = arb(2)**20000  # this one, which also stands for infinity at a pole that is one end of the domain,
NEXT_TO_ZERO = 1 / BEYOND  # or this one


@dataclass(frozen=True)
class Case:
    """One function, on number types and on balls; `slope` and `curvature` are its derivatives along SLOPES, by hand."""

    name: str
    phi: Callable
    true: Callable
    slope: Callable | None = None
    curvature: Callable | None = None
    ulps: Callable = lambda value: 1.0  # what rounding to nearest may cost `Interval`
    absolute: float = 0.0  # and that many units of 2**-52; inf where large terms cancel, and nothing is asked of it
    arity: int = 1
    reach: float = 308.3  # log10 of the largest second argument


def _power(p: float) -> Case:
    exponent = arb(p)
    short = fn.eighths(p)
    # exp(p log a): 5 units of the exponent's size in the exponent, 4 for exp
    ulps = (lambda v: short[0] + 4.0) if short else (lambda v: 8 + 6 * np.abs(np.log(np.abs(v))))
    return Case(f"a ** {p:g}", lambda a: fn.power(a, p), lambda a: _real_power(a, exponent),
                lambda a: exponent * _real_power(a, exponent - 1),
                lambda a: exponent * (exponent - 1) * _real_power(a, exponent - 2), ulps)


def _real_power(a: arb, b: arb) -> arb:
    if a == 0:
        return arb(0) if b > 0 else arb(1) if b == 0 else BEYOND
    return a**b if a > 0 else arb.nan()


def _whole(n: int) -> Case:
    return Case(f"a^{n}", lambda a: a**n, lambda a: a**n, lambda a: n * a**(n - 1) if n else arb(0),
                lambda a: n * (n - 1) * a**(n - 2) if n not in (0, 1) else arb(0), lambda v: abs(n) + 1.0)


def _exp(a: arb) -> arb:
    return a.exp() if abs(a) < FARTHEST else BEYOND if a > 0 else NEXT_TO_ZERO


def _cbrt(a: arb) -> arb:
    return a.root(3) if a > 0 else -((-a).root(3)) if a < 0 else arb(0)


def _reciprocal(a: arb) -> arb:
    return 1 / a if a != 0 else arb.nan()


def _far(function: Callable, sign: int) -> Callable:
    """`function`, which grows like exp |a|, of the sign of a where `sign` is -1."""
    return lambda a: function(a) if abs(a) < FARTHEST else BEYOND if a > 0 else sign * BEYOND


def _tanh_slope(a: arb, times=1) -> arb:
    return times / a.cosh()**2 if abs(a) < FARTHEST else NEXT_TO_ZERO


def _stairs(function: Callable, jumps: Callable, slope: float = 0.0) -> dict:
    """A function that jumps where `jumps` holds and has one slope elsewhere: nothing is asked at a jump."""
    return {"true": function, "slope": lambda *a: None if jumps(*a) else arb(slope),
            "curvature": lambda *a: None if jumps(*a) else arb(0)}


def _mod(a: arb, b: arb) -> arb:
    if b == 0:
        return arb.nan()
    p, q = a.fmpq(), b.fmpq()
    return arb(p - q * (p / q).floor())


def _mod_slope(a: arb, b: arb):
    if b == 0:
        return None
    whole = a.fmpq() / b.fmpq()
    return None if whole.q == 1 else 1 - arb(whole.floor()) / 2


def _within(function: Callable) -> Callable:
    """`function` on [-1, 1]."""
    return lambda a: function(a) if abs(a) <= 1 else arb.nan()


def _smooth_step(order: int) -> Callable:
    """The derivative of that order of t^2 (3 - 2 t) with t = (a + 0.5) / 1.75, held within [0, 1]."""
    def value(a: arb):
        t = (a + arb(0.5)) / arb(1.75)
        if t == 0 or t == 1:
            return arb(t) if order == 0 else arb(0) if order == 1 else None
        if t < 0 or t > 1:
            return arb(1 if t > 1 and order == 0 else 0)
        return (t * t * (3 - 2 * t), 6 * t * (1 - t) / arb(1.75), (6 - 12 * t) / arb(1.75)**2)[order]
    return value


FILLET = 0.75


def _smooth_minimum(a: arb, b: arb) -> arb:
    return a.min(b) - (FILLET - abs(a - b)).max(arb(0))**2 / (4 * FILLET)


def _smooth_minimum_slope(a: arb, b: arb):
    if a == b:
        return None
    near = (FILLET - abs(a - b)).max(arb(0)) / (2 * FILLET)
    return (arb(1) if a < b else arb(0.5)) + near * (a - b).sgn() * arb(0.5)


def _angle_slope(y: arb, x: arb):
    return None if y == 0 and x <= 0 else (x - y / 2) / (x * x + y * y)


def _log(a: arb) -> arb:
    return a.log() if a > 0 else -BEYOND if a == 0 else arb.nan()


CASES = [
    Case("negated", lambda a: -a, lambda a: -a, lambda a: arb(-1), lambda a: arb(0)),
    Case("a + b", lambda a, b: a + b, lambda a, b: a + b, lambda a, b: arb(1.5), lambda a, b: arb(0), arity=2),
    Case("a - b", lambda a, b: a - b, lambda a, b: a - b, lambda a, b: arb(0.5), lambda a, b: arb(0), arity=2),
    Case("a b", lambda a, b: a * b, lambda a, b: a * b, lambda a, b: b + a / 2, lambda a, b: arb(1), arity=2),
    Case("a / b", lambda a, b: a / b, lambda a, b: a * _reciprocal(b), lambda a, b: (1 - a / b / 2) / b,
         lambda a, b: (a / b / 2 - 1) / (b * b), arity=2),
    Case("3 / a", lambda a: 3.0 / a, lambda a: 3 * _reciprocal(a), lambda a: -3 / a**2, lambda a: 6 / a**3),
    Case("a * -0.7", lambda a: a * -0.7, lambda a: a * arb(-0.7), lambda a: arb(-0.7), lambda a: arb(0)),
    Case("a / 0.7", lambda a: a / 0.7, lambda a: a / arb(0.7), lambda a: 1 / arb(0.7), lambda a: arb(0)),
    Case("a a", lambda a: a * a, lambda a: a * a, lambda a: 2 * a, lambda a: arb(2), lambda v: 3.0),
    *map(_whole, (0, 2, 3, 4, 7, -1, -2, -3)),
    *map(_power, (2.5, 0.25, 0.625, 7.125, -1.5, -0.125, 0.3, 1.2, -2.37, 20.1)),
    Case("a ** b", fn.power, _real_power, lambda a, b: _real_power(a, b) * (b / a + _log(a) / 2), arity=2, reach=2.3,
         ulps=lambda v: 8 + 6 * np.abs(np.log(np.abs(v)))),
    Case("sqrt", fn.sqrt, lambda a: a.sqrt() if a >= 0 else arb.nan(), lambda a: 1 / a.sqrt() / 2,
         lambda a: -1 / (a * a.sqrt()) / 4),
    Case("cbrt", fn.cbrt, _cbrt, lambda a: 1 / _cbrt(a)**2 / 3, lambda a: -2 / (a * _cbrt(a)**2) / 9, lambda v: 4.0),
    Case("sin", fn.sin, arb.sin, arb.cos, lambda a: -a.sin(), lambda v: 0.0),
    Case("cos", fn.cos, arb.cos, lambda a: -a.sin(), lambda a: -a.cos(), lambda v: 0.0),
    Case("tan", fn.tan, arb.tan, lambda a: 1 + a.tan()**2, lambda a: 2 * a.tan() * (1 + a.tan()**2), lambda v: 1.0),
    Case("exp", fn.exp, _exp, _exp, _exp, lambda v: 4.0),
    Case("log", fn.log, _log, _reciprocal, lambda a: -1 / a**2, lambda v: 4.0),
    Case("abs", fn.absolute, abs, lambda a: a.sgn() if a != 0 else None, lambda a: arb(0) if a != 0 else None),
    Case("min", fn.minimum, arb.min, lambda a, b: None if a == b else arb(1) if a < b else arb(0.5),
         lambda a, b: arb(0) if a != b else None, arity=2),
    Case("max", fn.maximum, arb.max, lambda a, b: None if a == b else arb(1) if a > b else arb(0.5),
         lambda a, b: arb(0) if a != b else None, arity=2),
    Case("floor", fn.floor, **_stairs(arb.floor, lambda a: a == a.floor())),
    Case("ceil", composed.ceil, **_stairs(arb.ceil, lambda a: a == a.floor())),
    Case("heaviside", fn.heaviside, **_stairs(lambda a: arb(1 if a >= 0 else 0), lambda a: a == 0)),
    Case("sign", composed.sign, **_stairs(arb.sgn, lambda a: a == 0)),
    Case("fract", composed.fract, **_stairs(lambda a: a - a.floor(), lambda a: a == a.floor(), 1.0)),
    Case("mod", composed.mod, _mod, _mod_slope, arity=2, reach=4, ulps=lambda v: 0.0, absolute=math.inf),
    Case("atan2", fn.atan2, arb.atan2, _angle_slope, arity=2, ulps=lambda v: 6.0),
    Case("atan", composed.atan, arb.atan, lambda a: 1 / (1 + a * a), lambda a: -2 * a / (1 + a * a)**2, lambda v: 6.0),
    Case("asin", composed.asin, _within(arb.asin), lambda a: 1 / (1 - a * a).sqrt(), lambda a: a / (1 - a * a)**1.5,
         lambda v: 16.0),
    Case("acos", composed.acos, _within(arb.acos), lambda a: -1 / (1 - a * a).sqrt(), lambda a: -a / (1 - a * a)**1.5,
         lambda v: 16.0),
    Case("sinh", composed.sinh, _far(arb.sinh, -1), _far(arb.cosh, 1), _far(arb.sinh, -1), lambda v: 10.0, 8.0),
    Case("cosh", composed.cosh, _far(arb.cosh, 1), _far(arb.sinh, -1), _far(arb.cosh, 1), lambda v: 16.0),
    Case("tanh", composed.tanh, arb.tanh, _tanh_slope, lambda a: _tanh_slope(a, -2 * a.tanh()), lambda v: 10.0, 10.0),
    Case("smoothstep", lambda a: composed.smoothstep(-0.5, 1.25, a), *map(_smooth_step, range(3)), lambda v: 12.0),
    Case("mix", lambda a, b: composed.mix(a, b, 0.25), lambda a, b: a + (b - a) / 4, lambda a, b: arb(0.875),
         lambda a, b: arb(0), arity=2, ulps=lambda v: 0.0, absolute=math.inf),
    Case("smin", lambda a, b: composed.smin(a, b, FILLET), _smooth_minimum, _smooth_minimum_slope, arity=2, reach=2,
         ulps=lambda v: 8.0, absolute=8.0),
    Case("smax", lambda a, b: composed.smax(a, b, FILLET), lambda a, b: -_smooth_minimum(-a, -b),
         lambda a, b: None if a == b else arb(1.5) - _smooth_minimum_slope(a, b), arity=2, reach=2,
         ulps=lambda v: 8.0, absolute=8.0)]


# --- arguments -----------------------------------------------------------------------------------------------------
def _numbers(random: np.random.Generator, n: int, reach: float) -> np.ndarray:
    """Floats of every size and either sign; a fifth near multiples of pi/2 or at whole numbers."""
    kind = random.random(n)
    size = np.select([kind < 0.36, kind < 0.44, kind < 0.54, kind < 0.64, kind < 0.68],
                     [random.uniform(-4, min(4, reach), n), random.uniform(min(4, reach), min(17, reach), n),
                      random.uniform(min(17, reach), reach, n), random.uniform(-308, -4, n),
                      random.uniform(-323.5, -308, n)])
    with np.errstate(all="ignore"):
        x = 10.0**size
    whole = random.integers(0, 1 << random.integers(1, 31, n))
    whole = np.where(whole > 10.0**min(reach, 308), 1, whole)
    x = np.select([kind < 0.68, kind < 0.8, kind < 0.93], [x, whole * (0.5 * math.pi), whole], 0.0)
    x = np.where(random.random(n) < 0.1, np.nextafter(x, math.inf), x)
    return np.minimum(x, LARGEST) * random.choice([-1.0, 1.0], n)


def _intervals(random: np.random.Generator, n: int, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Bounds: thin, a few units in the last place, relatively narrow, any; some reach to infinity."""
    a, kind = _numbers(random, n, reach), random.random(n)
    with np.errstate(all="ignore"):
        near = a + np.spacing(a) * random.integers(-9, 10, n)
        narrow = a * (1 + 10.0**random.uniform(-15, 0, n))
    b = np.select([kind < 0.25, kind < 0.4, kind < 0.7], [a, near, narrow], _numbers(random, n, reach))
    limit = 10.0**reach if reach < 308 else LARGEST
    b = np.clip(b, -limit, limit)
    low, high = np.minimum(a, b), np.maximum(a, b)
    wide, below, above = kind >= 0.7, random.random(n) < 0.1, random.random(n) < 0.1
    if reach < 308:
        return low, high
    return np.where(wide & below, -math.inf, low), np.where(wide & above, math.inf, high)


def _points(random: np.random.Generator, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(n, POINTS) finite floats of every interval, in random order."""
    a, b = np.maximum(low, -LARGEST), np.minimum(high, LARGEST)
    share = random.random(len(a))
    inner = np.clip(a * (1 - share) + b * share, a, b)
    middle = np.where(random.random(len(a)) < 0.5, np.clip(_numbers(random, len(a), 308.3), a, b), inner)
    points = np.stack([a, b, inner, middle], axis=-1)
    return random.permuted(points, axis=1)


# --- true values ---------------------------------------------------------------------------------------------------
@dataclass
class Truth:
    """Values known as the float next to each and what is missing from it; NaN where there is none."""

    exact: list  # arb, or None
    nearest: np.ndarray
    rest: np.ndarray
    skipped: np.ndarray  # nothing is asked here: one of two slopes at a kink

    @classmethod
    def of(cls, function: Callable, arguments: tuple[list, ...]) -> Truth:
        exact, nearest, rest, skipped = [function(*point) for point in zip(*arguments)], [], [], []
        for value in exact:
            skipped.append(value is None)
            known = value is not None and value.is_finite()
            near = float(value) if known else math.nan
            nearest.append(near)
            rest.append(float(value - near) if math.isfinite(near) else 0.0)
        return cls(exact, np.array(nearest), np.array(rest), np.array(skipped))

    @property
    def floor(self):
        """The largest float that is not above the value."""
        below = np.where(self.rest < 0, np.nextafter(self.nearest, -math.inf), self.nearest)
        return np.where(self.nearest == math.inf, LARGEST, below)

    @property
    def ceiling(self):
        above = np.where(self.rest > 0, np.nextafter(self.nearest, math.inf), self.nearest)
        return np.where(self.nearest == -math.inf, -LARGEST, above)

    def outside(self, low, high, undefined_is_open: bool = True):
        """Where the interval [low, high] lacks the value, or is a claim where there is none."""
        claims = (low > -math.inf) & (high < math.inf)
        if undefined_is_open:
            claims = (low > -math.inf) | (high < math.inf)
        wrong = (low > self.floor) | (high < self.ceiling) | (np.isnan(self.nearest) & claims)
        return wrong & ~self.skipped


# --- number types --------------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Kind:
    """A number type on one array type."""

    number: type[Interval]
    on_drjit: bool

    @property
    def name(self):
        return f"{self.number.__name__} on {'Dr.Jit' if self.on_drjit else 'NumPy'}"

    def enclose(self, phi: Callable, bounds) -> tuple[tuple, tuple]:
        """(low, high) of phi and of its derivative, by duals of intervals."""
        array, n = (backend().Float if self.on_drjit else np.asarray), len(bounds[0][0])
        if self.on_drjit:
            bounds = [_as_threads_read(*b) for b in bounds]
        arguments = [Dual(self.number(array(low), array(high)), (self.number(slope),))
                     for (low, high), slope in zip(bounds, SLOPES)]
        with np.errstate(all="ignore"):
            result = phi(*arguments)
        value, slope = self.number.of(result.value), self.number.of(result.derivative())
        plain = lambda bound: np.broadcast_to(array(bound).numpy() if self.on_drjit else bound, n)
        return (plain(value.low), plain(value.high)), (plain(slope.low), plain(slope.high))


KINDS = [Kind(number, on_drjit) for number in (Interval, OutwardInterval) for on_drjit in (False, True)]


def _as_threads_read(low, high):
    """Bounds outward to what Dr.Jit's threads can read: no subnormal numbers."""
    subnormal = lambda v: (v != 0) & (np.abs(v) < SMALLEST_NORMAL)
    return (np.where(subnormal(low), np.where(low > 0, 0.0, -SMALLEST_NORMAL), low),
            np.where(subnormal(high), np.where(high < 0, 0.0, SMALLEST_NORMAL), high))


@dataclass(frozen=True)
class Result:
    """How one function of one type fared."""

    function: str
    type: str
    arguments: int
    outside: int
    width: float  # median for a thin interval, in units in the last place; NaN where none was finite
    example: str = ""

    def __str__(self):
        return f"{self.function:12} {self.type:36} {self.arguments:9} {self.outside:8} {self.width:10.3g}  {self.example}"


def _result(case: Case, kind: str, outside, width, points) -> Result:
    example = ""
    if np.any(outside):
        i = np.flatnonzero(outside)[0]
        example = "at " + ", ".join(repr(float(p[i])) for p in points)
    finite = width[np.isfinite(width)]
    return Result(case.name, kind, len(outside), int(np.sum(outside)), float(np.median(finite)) if len(finite) else math.nan,
                  example)


@precision(BITS)
@np.errstate(all="ignore")
def check(case: Case, count: int, seed: int = 1, kinds=KINDS, series: bool = True) -> list[Result]:
    """Holds one function of every type against true values at about `count` random arguments."""
    random, n = np.random.default_rng(seed), max(1, count // POINTS)
    bounds = [_intervals(random, n, 308.3 if k == 0 else case.reach) for k in range(case.arity)]
    points = [_points(random, *b).ravel() for b in bounds]
    balls = tuple([arb(x) for x in p.tolist()] for p in points)
    value, slope = Truth.of(case.true, balls), Truth.of(case.slope, balls)
    slope.skipped |= np.isnan(value.nearest)
    thin = np.repeat(np.logical_and.reduce([low == high for low, high in bounds]), POINTS)
    found = []
    for kind in kinds:
        (low, high), slopes = kind.enclose(case.phi, bounds)
        low, high, *slopes = (np.repeat(b, POINTS) for b in (low, high, *slopes))
        width = _width(low, high, value, thin)
        if kind.number is Interval:
            low, high = _granted(case, low, -1), _granted(case, high, 1)
        found.append(_result(case, kind.name, value.outside(low, high), width, points))
        if kind.number is OutwardInterval:
            found.append(_result(case, kind.name + ", slope", slope.outside(*slopes, undefined_is_open=False),
                                 _width(*slopes, slope, thin), points))
    if series:
        found.append(_check_series(case, bounds, balls, points, value, slope))
    return found


def _width(low, high, truth: Truth, thin):
    """The width of enclosures of single points in units in the last place, NaN for the others."""
    return np.where(thin & (truth.nearest != 0), (high - low) / np.spacing(np.abs(truth.nearest)), math.nan)


def _granted(case: Case, bound, direction: int):
    """A bound of an `Interval` moved by the rounding it may hold; inf on the wrong side bounds nothing."""
    ulps = case.ulps(bound)
    error = (np.abs(bound) * np.where(np.isfinite(ulps), ulps, 0) + case.absolute) * 2.0**-52 + 2 * SMALLEST_NORMAL
    return np.where(bound == -direction * math.inf, math.nan, bound + direction * error)


def _check_series(case: Case, bounds, balls, points, value: Truth, slope: Truth) -> Result:
    """The same for `Series`: value, first and second derivative over the ball of every interval."""
    outside, width = np.zeros(len(points[0]), bool), np.full(len(points[0]), math.nan)
    curvature = None if case.curvature is None else [case.curvature(*point) for point in zip(*balls)]
    for i, ends in enumerate(zip(*(np.stack(b, axis=-1).tolist() for b in bounds))):
        if not all(math.isfinite(v) for pair in ends for v in pair):
            continue
        arguments = [Series(arb_series([arb(low).union(arb(high)) if low < high else arb(low), arb(along)]), low >= 0)
                     for (low, high), along in zip(ends, SLOPES)]
        result = case.phi(*arguments)
        s = (result.s if isinstance(result, Series) else Series.constant(result).s)
        found = [s[0], s[1], 2 * s[2]]
        thin = all(low == high for low, high in ends)
        for k in range(i * POINTS, (i + 1) * POINTS):
            if thin and value.nearest[k]:
                width[k] = 2 * float(s[0].rad()) / np.spacing(abs(value.nearest[k]))
            for ball, exact in zip(found, (value.exact, slope.exact, curvature)):
                expected = exact and exact[k]
                if expected is not None and abs(expected) not in (BEYOND, NEXT_TO_ZERO):
                    # where there is no value, none may be claimed; else the ball must meet the true one
                    outside[k] |= ball.is_finite() and not (expected.is_finite() and ball.overlaps(expected))
    return _result(case, "Series, two derivatives", outside, width, points)


# --- functions of floats -------------------------------------------------------------------------------------------
FLOATS = {"sqrt": (fn.sqrt, arb.sqrt), "cbrt": (fn.cbrt, _cbrt), "exp": (fn.exp, _exp), "log": (fn.log, _log),
          "sin": (fn.sin, arb.sin), "cos": (fn.cos, arb.cos), "atan2": (fn.atan2, arb.atan2)}


@precision(BITS)
@np.errstate(all="ignore")
def float_errors(name: str, count: int, on_drjit: bool, seed: int = 2) -> tuple[float, float]:
    """The largest error of a function of floats whose argument and value are finite and normal, and what is granted: for
    sine and cosine absolute and up to LARGEST_ANGLE, for others in units in the last place."""
    function, true = FLOATS[name]
    x = _numbers(np.random.default_rng(seed), count, 308.3)
    wave = name in ("sin", "cos")
    if wave:
        x = x[np.abs(x) <= fn.LARGEST_ANGLE]
    elif name not in ("cbrt", "atan2"):
        x = x[x > 0] if name != "exp" else np.clip(x, -745, 709.7)
    x = x[(np.abs(x) >= SMALLEST_NORMAL)]
    arguments = (x, np.roll(x, 1)) if name == "atan2" else (x,)
    truth = Truth.of(true, tuple([arb(v) for v in a.tolist()] for a in arguments))
    y = function(*map(backend().Float, arguments)).numpy() if on_drjit else function(*arguments)
    normal = (np.abs(truth.nearest) >= SMALLEST_NORMAL) & np.isfinite(truth.nearest) & np.isfinite(y)
    error = np.abs((y - truth.nearest) - truth.rest)
    if wave:
        return float(np.max(error[normal])), stated.WAVE_ERROR
    return float(np.max((error / np.spacing(np.abs(truth.nearest)))[normal])), float(stated.ULPS[name])


def main(arguments=None) -> int:
    parser = argparse.ArgumentParser(prog="enclosures",
                                     description="Holds every number type against python-flint on random arguments.")
    parser.add_argument("--count", type=int, default=1_000_000, help="arguments of each function (default: %(default)s)")
    parser.add_argument("--only", nargs="+", metavar="FUNCTION", choices=[c.name for c in CASES],
                        help="these functions only: " + ", ".join(c.name for c in CASES))
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    if options.count < POINTS:
        parser.error(f"--count must be at least {POINTS}; found {options.count}")
    print(f"{'function':12} {'type':36} {'arguments':>9} {'outside':>8} {'width, ulp':>10}")
    outside = 0
    for case in CASES:
        if options.only is None or case.name in options.only:
            for result in check(case, options.count, options.seed):
                outside += result.outside
                print(result, flush=True)
    print(f"\n{'of floats':12} {'on':8} {'largest error':>14} {'granted':>10}")
    for name in FLOATS:
        if options.only is None or name in options.only:
            for on_drjit in (False, True):
                error, granted = float_errors(name, options.count, on_drjit)
                outside += error > granted
                print(f"{name:12} {'Dr.Jit' if on_drjit else 'NumPy':8} {error:14.3g} {granted:10.3g}", flush=True)
    print(f"\n{outside} outside")
    return 1 if outside else 0


if __name__ == "__main__":
    sys.exit(main())
