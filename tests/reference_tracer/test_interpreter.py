"""Formulas as programs: the interpreter does what the number types do, bit by bit, and small pictures show what compiled ones do."""

import drjit as dr
import numpy as np
import pytest
from formulas_as_written import FORMULAS
from tracing_support import make_scene, thing

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.numbers import Dual, Interval, OutwardInterval, Polynomial, interpreter
from raytruth.reference_tracer.numbers.interpreter import Interpreter
from raytruth.reference_tracer.numbers.program import LENGTH, OPERATIONS, Program
from raytruth.reference_tracer.surfaces import Expression
from raytruth.reference_tracer.surfaces.interpreted import HIGHEST_DEGREE, programs_of
from raytruth.reference_tracer.tracer import render as rendering
from raytruth.reference_tracer.tracer.film import PLANES
from raytruth.reference_tracer.tracer.interpreting import MOST_RAYS, InterpretingWorld
from raytruth.reference_tracer.tracer.render import Renderer, render

ARRAYS = backend()
ORDINARY, EXTREME = 400, 80  # points
FLOATS = (64, -64, 1e-3, -1e-3, 0.0, 1e200)
CASES = {  # every operation is in one of them
    "a polynomial": "(x**2 + y**2*0.7 - z)**2*3 - x*y*z/7 + 2 - (-(x - 1))*(y + 2)**3",
    "quotients and roots": "sqrt(x*x*y*y*z**2 + 1)/(y - 3) - 2/(x*x + 1) + abs(z)",
    "roots of products": "sqrt(abs(x)*y**2) + sqrt(x*y*x*y) - 1",
    "waves": "sin(3*x)*cos(2*y) + tan(z)*sin(x) - 0.5",
    "growth": "exp(x - y) + ln(z*z + 0.5) + cosh(y) - x**5 + y**6",
    "angles": "atan2(y, x) + asin(sin(z)*0.5) - atan(x)",
    "edges": "max(x - 0.5, min(y, -z), abs(x) - 1)"}


def points(number) -> tuple:
    """Points on a number type, as methods ask for them, those of a grid and those where arithmetic is at its limits."""
    random = np.random.default_rng(2)
    xyz = np.concatenate([random.uniform(-2, 2, (3, ORDINARY)), random.choice(FLOATS, (3, EXTREME))], axis=1)
    o = [ARRAYS.Float(v) for v in xyz]
    d = [ARRAYS.Float(v) for v in random.normal(size=(3, ORDINARY + EXTREME))]
    spans = lambda kind: [kind(v, v + ARRAYS.Float(random.uniform(0, 0.3, ORDINARY + EXTREME))) for v in o]
    match number:
        case "float":
            return tuple(o)
        case "along a ray":
            return Dual.along(o, d)
        case "gradient":
            return Dual.axes(o)
        case "interval":
            return Dual.along(spans(Interval), [Interval(v) for v in d])
        case "proof":
            return Dual.along(spans(OutwardInterval), [OutwardInterval(v) for v in d])
        case "point of a proof":
            return tuple(OutwardInterval(v) for v in o)
        case "polynomial":
            return Polynomial.along(o, d)


def numbers(value) -> list[np.ndarray]:
    """What a number consists of."""
    match value:
        case Dual():
            return [part for v in (value.value, *map(value.derivative, range(len(value.derivatives)))) for part in numbers(v)]
        case Interval():
            return [part for v in (value.low, value.high) for part in numbers(v)]
        case Polynomial():
            return [part for c in value.c for part in numbers(c)]
    return [np.broadcast_to(np.asarray(value.numpy() if dr.is_array_v(value) else value), ORDINARY + EXTREME)]


def differences(formula: str, number: str) -> int:
    """How many numbers of the interpreter's are not those of the number type itself, to the last bit.

    A derivative that is known to be zero is a zero like any other to the interpreter, which has NaN for it where numbers
    overflow: there it may know less.
    """
    found, meant = both(formula, number)
    meant += [np.zeros(ORDINARY + EXTREME)] * (len(found) - len(meant))  # coefficients beyond the degree
    unequal = [~((a == b) | (np.isnan(a) & (np.isnan(b) | (np.arange(ORDINARY + EXTREME) >= ORDINARY))))
               for a, b in zip(found, meant, strict=True)]
    return np.count_nonzero(unequal)


def both(formula: str, number: str) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """What the interpreter makes of the points, and what the number type itself does."""
    surface = Expression(formula=formula)
    form, given = surface.regular_form, {name: ARRAYS.constant(value) for name, value in surface.parameters.items()}
    program = Program.of(lambda x, y, z: form(x, y, z, **surface.parameters), polynomial=number == "polynomial")
    interpreted = Interpreter(program, ARRAYS, HIGHEST_DEGREE, surface.degree or 0)
    return numbers(interpreted(*points(number))), numbers(form(*points(number), **given))


NUMBERS = ["float", "along a ray", "gradient", "interval", "proof", "point of a proof"]


# the angles' numbers have derivatives that are known to be zero, which an enclosure that rounds outwards then widens
EXACT = [(name, number) for name in CASES for number in NUMBERS if (name, number) != ("angles", "proof")]


@pytest.mark.parametrize("name, number", [("a polynomial", "polynomial"), *EXACT])
def test_a_program_does_what_the_number_type_does(name, number):
    assert differences(CASES[name], number) == 0


def test_an_enclosure_by_a_program_holds_the_number_type_s_own():
    found, meant = both(CASES["angles"], "proof")
    for (low, high), (own_low, own_high) in zip(zip(found[::2], found[1::2]), zip(meant[::2], meant[1::2])):
        known = np.isfinite(low) & np.isfinite(high)
        assert known[:ORDINARY].mean() > 0.8
        assert (low <= own_low)[known].all() and (high >= own_high)[known].all()
        assert (high - low <= (own_high - own_low) * (1 + 1e-12) + 1e-12)[known].all()


@pytest.mark.parametrize("operation", [name for name in OPERATIONS if name not in ("of sign", "not negative")])
def test_an_operation_that_does_something_else_is_noticed(operation, monkeypatch):
    k = OPERATIONS.index(operation)
    wrong = interpreter.MEANINGS[OPERATIONS.index("sub" if operation == "add" else "add")]
    monkeypatch.setattr(interpreter, "MEANINGS", [*interpreter.MEANINGS[:k], wrong, *interpreter.MEANINGS[k + 1:]])
    assert any(differences(formula, "float") for formula in CASES.values())


def test_an_interval_without_the_signs_of_products_is_noticed(monkeypatch):
    """The root of a square: rounding moves its lower bound below zero, and only its structure tells that it is none."""
    wrong = {"of sign": lambda a, b, c: a, "not negative": lambda a, b, c: a, "signed mul": lambda a, b, c: a * b}
    right = dict(zip(OPERATIONS, interpreter.MEANINGS))
    monkeypatch.setattr(interpreter, "MEANINGS", list((right | wrong).values()))
    assert differences(CASES["roots of products"], "interval") > 0


def test_programs_that_are_too_long_or_do_what_is_no_operation_are_refused():
    for formula in ("floor(x)", "cbrt(x) + y", "abs(x)**2.5 + y", "x**y + z", "+".join(f"sin({k}*x)" for k in range(1, LENGTH // 3))):
        assert programs_of(Expression(formula=formula)) is None, formula
    nested = "x"
    for k in range(28):
        nested = f"sin({k}*y)*({nested}) + cos({k}*z)"
    program, _ = programs_of(Expression(formula=nested))  # registers are used again
    assert 100 < len(program.words) <= LENGTH


# --- pictures -----------------------------------------------------------------------------------------------------------
def scene(formula: str, size=(48, 36), parameters=None, **surface):
    return make_scene(thing("expression", (0, 0, 5), formula=formula, parameters=parameters or {}, **surface), size=size)


def is_interpreted(scene, method="exact", **rest) -> bool:
    return isinstance(Renderer(scene, method, **rest).world, InterpretingWorld)


SHOWN = [w for w in FORMULAS if w.formula in (
    "(x^2+9/4*y^2+z^2-1)^3=(x^2+9/80*y^2)*z^3", "x^2+y^2+z^2+sin(4*x)-cos(4*y)+sin(4*z)-1",
    "(R - √(x² + y²))² + z² = r²", "max(length(x, z) - .4, abs(y) - .9)", "x² + y² = cosh²(z)", "xyz = 0",
    "sqrt(x*x + y*y + z*z) - 0.9\n\t\t+ sin(12*atan2(x, z))*0.1", "x² + y²z³ = z⁴")]


@pytest.mark.parametrize("written", SHOWN, ids=lambda w: w.formula[:30])
@pytest.mark.parametrize("limit", ["", "clip"])
def test_interpreted_and_compiled_pictures_are_equal_to_the_last_bit(written, limit):
    corner = [1.5 * written.size] * 3
    box = {limit: {"low": [-c for c in corner], "high": corner}} if limit else {}
    shown = scene(written.formula, parameters=written.parameters, **box)
    assert is_interpreted(shown)
    for found, meant in zip(*(vars(render(shown, interpret=way)).items() for way in (None, False))):
        if found[0] in PLANES:
            np.testing.assert_array_equal(found[1], meant[1], found[0])


@pytest.mark.parametrize("formula", ["x^2 + y^2 + z^2 - 1", "z - x*y/3", "x + y - 2*z", "x^4/3 + y^4 + z^2/7 - 1",
                                     "e^z*cos(x) - cos(y)"])
def test_where_another_way_is_the_compiled_one_pictures_agree_to_rounding(formula):
    """Closed forms of quadrics, for which the interpreter asks Descartes' rule; quotients by numbers, which Dr.Jit turns over;
    powers of numbers, whose slopes are rounded in another order."""
    found, meant = (render(scene(formula), interpret=way) for way in (None, False))
    np.testing.assert_array_equal(found.index, meant.index)
    np.testing.assert_array_equal(found.status, meant.status)
    np.testing.assert_allclose(found.t, meant.t, rtol=1e-13)
    np.testing.assert_allclose(found.normal, meant.normal, atol=1e-11)


def test_formulas_share_one_kernel():
    render(scene("x^4 + y^4 + z^4 - 1"))
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        render(scene("sin(x*y) + cos(z)*exp(y/4) - 0.6"))
        render(scene("x^3*y + x*z^3 + y^3*z + z^3 + 5*z"))
        kernels = [k for k in dr.kernel_history() if k["type"] == dr.KernelType.JIT]
    assert kernels and all(k["cache_hit"] for k in kernels)


def test_worlds_that_kernels_can_tell_apart_share_no_recordings(monkeypatch):
    rest = {"lights": [((0, 3, 0), [1.0] * 3)]}
    scenes = {"plain": scene("x^4 + y^4 + z^4 - 1"), "other": scene("sin(x) + y"),
              "bounded": scene("x^4 + y^4 + z^4 - 1", bounds={"low": [-2] * 3, "high": [2] * 3}),
              "flipped": scene("x^4 + y^4 + z^4 - 1", inside="positive"),
              "drowned": scene("((x^2 + y^2 + z^2 - 1) + 1e9) - 1e9"),
              "turned": make_scene(thing("expression", (0, 0, 5), formula="sin(x) + y", rotation={"axis": [1, 0, 0], "degrees": 9.0}),
                                   size=(48, 36), **rest)}
    structures = {name: Renderer(s).world.structure for name, s in scenes.items()}
    assert structures.pop("other") == structures["plain"] and len(set(structures.values())) == len(structures)
    a, b = (render(scenes[name], interpret=way) for name, way in (("turned", None), ("turned", False)))
    np.testing.assert_array_equal(a.color, b.color)


def test_what_is_interpreted_is_told_by_the_scene_alone():
    small, formula = (160, 120), "x^4 + y^4 + z^4 - 1"
    assert small[0] * small[1] <= MOST_RAYS and is_interpreted(scene(formula, small))
    assert not is_interpreted(scene(formula, (161, 125)))
    assert not is_interpreted(scene(formula, (160, 120)).traced_with(samples=2))
    assert not is_interpreted(scene(formula), "paper") and not is_interpreted(scene(formula), precision=32)
    assert not is_interpreted(scene("floor(x) + y")) and not is_interpreted(scene(formula), interpret=False)
    mirror = thing("expression", (0, 0, 5), formula=formula, material={"reflection": 0.5})
    assert not is_interpreted(make_scene(mirror, size=small))
    assert not is_interpreted(make_scene(thing("torus", (0, 0, 5), R=1, r=0.4), size=small))


def test_a_recording_is_forgotten_when_many_others_came(monkeypatch):
    monkeypatch.setattr(rendering, "MOST_SHARED", 1)
    first = Renderer(scene("sin(x) + y")).recordings
    assert Renderer(scene("cos(x) + y")).recordings is first
    Renderer(scene("sin(x) + y", inside="positive"))
    assert Renderer(scene("sin(x) + y")).recordings is not first
