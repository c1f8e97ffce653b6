"""User formulas: what they mean is what Python means by them, and nothing of them is ever executed."""

import json
import math
import subprocess
import sys
import warnings

import numpy as np
import pytest
from tracing_support import make_scene, thing

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.surfaces import Expression
from raytruth.reference_tracer.surfaces.formula_functions import LARGEST_EXPONENT
from raytruth.reference_tracer.tracer.render import UNDECIDED, render

POINTS = [(0.7, -1.3, 2.1), (-0.4, 0.9, 0.3), (1.5, 2.5, -0.8)]
NAMES = {name: getattr(math, name) for name in ("sqrt", "sin", "cos", "tan", "exp", "log", "pi")} | {
    "cbrt": lambda v: math.copysign(abs(v)**(1 / 3), v), "abs": abs, "min": min, "max": max}

FORMULAS = [
    "x", "-x", "+x", "--x", "x + y - z", "x - y - z", "x - (y - z)", "x*y/z", "x/y/z", "x/(y/z)", "x + y*z",
    "(x + y)*z",
    "-x**2", "(-x)**2", "2*x**2*3", "x**2**1", "x**-2", "-x**-3", "x**2.0", "x - -y", "x*-y", "x/-2", "2 - x", "1/x",
    "1e-3*x + .5*y + 5.*z", "1_000*x", "0x10*x", "x**0 + y", "x**1", f"x**{LARGEST_EXPONENT}",
    "sqrt(x**2 + y**2)", "cbrt(x)*cbrt(y*z)", "sin(x)*cos(y) - tan(z)", "exp(-x**2)/(1 + y**2)", "log(2 + abs(z))",
    "min(x, y) + max(y, z)", "max(min(x, 1), -1)", "sin(pi*x)", "(x**2 + 1)**y", "2**x", "abs(x)**0.5", "((((x))))",
    "(x**2 + 9/4*z**2 + y**2 - 1)**3 - x**2*y**3 - 9/80*z**2*y**3",
    # powers whose exponent is a constant, written as an expression
    "x**(2)**2", "x**(1 + 1)", "x**(4/2)", "x**-(2)", "x**(3 - 1) + y**+2"]


def expression(formula: str) -> Expression:
    return Expression(formula=formula)


@pytest.mark.parametrize("formula", FORMULAS)
def test_a_formula_means_what_python_means_by_it(formula):
    """Python's own evaluation of the same text on floats is the expected value: precedence, associativity, numbers."""
    for x, y, z in POINTS:
        expected = eval(formula, {"__builtins__": {}}, NAMES | {"x": x, "y": y, "z": z})
        assert expression(formula)(x, y, z) == pytest.approx(expected, rel=1e-14), (x, y, z)


@pytest.mark.parametrize("formula", [f for f in FORMULAS if "x**(" not in f])
def test_a_formula_on_arrays_is_the_formula_on_floats(formula):
    surface, Float = expression(formula), backend().Float
    x, y, z = np.array(POINTS).T
    expected = [surface(*point) for point in POINTS]
    np.testing.assert_allclose(np.broadcast_to(surface(x, y, z), 3), expected, rtol=2e-14)
    np.testing.assert_allclose(Float(surface(Float(x), Float(y), Float(z))).numpy(), expected, rtol=2e-14)


@pytest.mark.parametrize("formula, degree", [
    ("x", 1), ("x - 2*y + 3", 1), ("x**2 + y**2 - 1", 2), ("x*y*z - 1", 3),
    ("(x**2 + y**2 + z**2 + 3)**2 - 16*(x**2 + y**2)", 4),
    ("x/2 + y", 1), ("sqrt(x)", None), ("1/x", None), ("x**-1", None), ("x**0.5", None), ("abs(x) - 1", None),
    ("exp(2)*x", 1), ("x**y", None)])
def test_the_degree_of_a_formula_is_found(formula, degree):
    """It decides whether a closed form may be used."""
    assert expression(formula).degree == degree


REFUSED = {
    "a call": "eval('1')", "an import": "__import__('os').system('true')", "an attribute": "x.real",
    "a method": "x.f(1)",
    "a subscript": "x[0]", "an unknown name": "w + x", "a dunder": "__builtins__", "an unknown function": "sen(x)",
    "a keyword": "sin(x=1)", "too few arguments": "max(x)", "too many": "sin(x, y)",
    "star": "max(*x)", "a lambda": "lambda: x", "a comprehension": "[x for x in y]", "a string": "'x'",
    "an f-string": "f'{x}'", "bytes": "b'x' + x", "a condition": "x if y else z",
    "a condition as a number": "x*(y < 1)", "an equation in a solid": "x < 1 and y = 2", "two equations": "x = y = z",
    "a walrus": "(w := x)", "floor division": "x // 2", "modulo": "x % 2",
    "matrix product": "x @ y", "shift": "x << 2", "bit not": "~x", "a complex number": "1j*x", "a truth": "True*x",
    "nothing": "None", "dots": "...", "infinity": "1e999*x", "a huge whole number": "9"*400 + "*x",
    "a statement": "import os",
    "two statements": "x; y", "a coordinate with a value": "x = 1; y", "an empty side": "x =", "empty": "", "blank": "   ", "unbalanced": "(x",
    "not a formula": "x +",
    "a constant": "2 + 2", "only pi": "pi", "a huge exponent": f"x**{LARGEST_EXPONENT + 1}", "a tower": "x**9**9**9**9",
    "a very negative exponent": "x**-99", "too long": "x" + " + x" * 600, "too many operations": "+".join("x" * 400),
    "nested parentheses": "sqrt(" * 70 + "x" + ")" * 70, "deep signs": "-" * 300 + "x",
    "very deep parentheses": "(" * 900 + "x" + ")" * 900,
    "a null byte": "x\0", "yield": "(yield x)", "await": "await x", "a decorator": "@x", "a comment alone": "# x"}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_formula_is_refused_in_one_line(name):
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        with pytest.raises(InputError) as error:
            make_scene(thing("expression", formula=REFUSED[name]))
    assert "objects[0].surface.formula" in str(error.value) and len(str(error.value).splitlines()) == 1
    assert not seen


@pytest.mark.parametrize("formula", ["0in x", "'\\d'", "1 is x", "x if 1else 0"])
def test_refusing_a_formula_prints_nothing_beside_the_error(formula):
    """Python's parser warns of some texts on standard error; the user gets one line, not two."""
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        with pytest.raises(InputError):
            make_scene(thing("expression", formula=formula))
    assert not seen


def test_nothing_is_executed(tmp_path, monkeypatch):
    """Formulas that would leave a trace if they ran; eval and exec themselves are made to fail."""
    def forbidden(*_):
        raise AssertionError("executed")
    trace = tmp_path / "trace"
    monkeypatch.setattr("builtins.eval", forbidden)
    monkeypatch.setattr("builtins.exec", forbidden)
    for formula in (f"open({str(trace)!r}, 'w')", f"__import__('pathlib').Path({str(trace)!r}).touch()",
                    f"[x for x in ().__class__.__base__.__subclasses__()] + open({str(trace)!r}, 'w')"):
        with pytest.raises(InputError):
            make_scene(thing("expression", formula=formula))
    assert not trace.exists()
    assert expression("x**2 + sin(y)")(2.0, 0.0, 0.0) == 4.0


@pytest.mark.parametrize("formula", ["1/x - 1", "x**-2 - 1", "x + 1/0", "1e300**30*x", "(1e200 + x)**2 - 1",
                                     "0/0*x + y"])
def test_a_formula_without_a_value_at_the_camera_is_no_crash(formula):
    """1/x has a pole at the camera. M7: what is not finite counts as outside; a formula that never has a value may as
    well be refused. Either way there is an answer, not a traceback."""
    document = {"camera": {"width": 3, "height": 2},
                "objects": [{"surface": {"type": "expression", "formula": formula}}],
                "lights": [{"position": [0, 1, 0]}]}
    try:
        picture = render(parse_scene(json.dumps(document).encode()), "paper")
    except InputError as error:
        assert "formula" in str(error)
    else:
        assert picture.status.max() <= UNDECIDED


def test_towers_of_powers_cost_no_time():
    """The degree of this short formula is 32^4: to multiply it out takes hours. In a process that can be ended."""
    code = ("from raytruth.reference_tracer.surfaces import Expression\n"
            "print(Expression(formula='(((x**32 + y)**32)**32)**32').degree)")
    subprocess.run([sys.executable, "-c", code], timeout=20, check=True, capture_output=True)


def test_bounds_are_the_box_and_must_be_in_order():
    bounded = Expression.model_validate_json('{"type": "expression", "formula": "x**2 + y**2 + z**2 - 1", '
                                             '"bounds": {"low": [-1, -1, -1], "high": [1, 1, 1]}}')
    assert bounded.box() == ((-1, -1, -1), (1, 1, 1)) and expression("x").box() is None
    with pytest.raises(InputError, match="every number of low"):
        make_scene(thing("expression", formula="x", bounds={"low": [0, 0, 0], "high": [1, 0, 1]}))
