"""The notation of formulas: what is the same however it is written, and what faults are told like."""

import json
import random

import pytest

from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import json_schema
from raytruth.reference_tracer.surfaces import Expression
from raytruth.reference_tracer.surfaces.formula import FormulaError
from raytruth.reference_tracer.surfaces.formula_parser import parse_formula

VALUES = (("R", 2.0), ("k", 0.5), ("radius", 3.0))

SAME = [
    ("x^2", "x**2"), ("x²", "x**2"), ("x⁻²", "x**-2"), ("x^2^3", "x**2**3"), ("-x^2", "-x**2"), ("2^-x", "2**-x"), ("x¹⁰", "x**10"),
    ("2x", "2*x"), ("x y", "x*y"), ("xyz", "x*y*z"), ("3(x+1)", "3*(x+1)"), ("(x+1)(y-1)z", "(x+1)*(y-1)*z"), ("2x²y", "2*x**2*y"),
    ("x·y×z", "x*y*z"), ("x−y", "x-y"), ("x÷2", "x/2"), ("x.^2 + y.*z", "x**2 + y*z"), ("[x+{y-1}]2.5x".replace("2.5", ""), "(x+(y-1))*x"),
    ("1/2x", "1/2*x"), ("9/4y²", "9/4*y**2"), ("2x/3", "2*x/3"), ("2^3x", "2**3*x"), ("x^2y", "x**2*y"), ("2pix", "2*pi*x"), ("2πx", "2*pi*x"),
    ("sin x", "sin(x)"), ("sin 2x", "sin(2*x)"), ("2sin(x)y", "2*sin(x)*y"), ("sin 2 pi x", "sin(2*pi*x)"), ("sin x^2", "sin(x**2)"),
    ("sin^2 x", "sin(x)**2"), ("sin²(x)", "sin(x)**2"), ("sin x cos y", "sin(x)*cos(y)"), ("sin -x", "sin(-x)"), ("cos sin x", "cos(sin(x))"),
    ("√(x²+y²)", "sqrt(x**2+y**2)"), ("√x", "sqrt(x)"), ("Sin[x]", "sin(x)"), ("sinx", "sin(x)"), ("xcos(y)", "x*cos(y)"),
    ("|x|", "abs(x)"), ("||x|-1| - |y|", "abs(abs(x)-1) - abs(y)"), ("2|x||y|", "2*abs(x)*abs(y)"), ("max(|x|,|y|)", "max(abs(x),abs(y))"),
    ("x^2+y^2 = 1", "x**2+y**2-1"), ("x = 0", "x"), ("z = x y", "z-x*y"), ("0 = x - y", "-(x-y)"), ("x+y==z", "x+y-z"), ("x = (y-1)", "x-(y-1)"),
    ("x < 1", "x-1"), ("x > 1", "1-x"), ("x <= y", "x-y"), ("x ≥ y", "y-x"), ("x > 0", "-x"), ("0 < x < 2", "max(-x, x-2)"),
    ("x<1 and y<1", "max(x-1, y-1)"), ("x<1 || y<1", "min(x-1, y-1)"), ("not x<1", "-(x-1)"), ("!(x<1) && y<1", "max(-(x-1), y-1)"),
    ("x<1 or y<1 and z<1", "min(x-1, max(y-1, z-1))"), ("(x<1 or y<1) AND z<1", "max(min(x-1, y-1), z-1)"), ("x<1 and y", "max(x-1, y)"),
    ("x<1 ∩ y<1", "max(x-1, y-1)"), ("min(x,y,z)", "min(min(x,y),z)"), ("max(x,y,z,1)", "max(max(x,y),max(z,1))"),
    ("X^2 + Y*Z", "x**2 + y*z"), ("p.x + pos.y", "x + y"), ("1.x + .5y + 1e-3z", "1.*x + .5*y + 1e-3*z"), ("R x", "2*x"), ("x - radius", "x-3"),
    ("kx", "0.5*x"), ("x^2 + y^2 = R²", "x**2 + y**2 - 2**2"), ("pow(x,3)", "x**3"), ("sqr(x)+hypot(y,z)", "x**2+sqrt(y**2+z**2)"), ("ln x", "log(x)"),
    ("arctan(x)", "atan(x)"), ("atan(y,x)", "atan2(y,x)"), ("clamp(x,0,1)", "min(max(x,0),1)"), ("step(1,x)", "heaviside(x-1)"), ("e^x", "2.718281828459045**x"),
    ("let r = x^2+y^2; r - 1", "(x**2+y**2) - 1"), ("r = x+1\ns = r^2\ns + r", "(x+1)**2 + (x+1)"), ("float d = x - 1.; return d;", "x - 1."),
    ("f(x,y,z) = x + y", "x+y"), ("d = x + y", "x+y"), ("x +\n y", "x+y"), ("x\n+ y", "x+y"), ("max(x,\n  y)", "max(x,y)"), ("\n x \n\n", "x"), ("xyz = 0", "x*y*z"),
    ("2^x y", "2**x*y"), ("x²/a²".replace("a", "R"), "x**2/2**2")]


@pytest.mark.parametrize("written, plain", SAME)
def test_it_is_the_same_however_it_is_written(written, plain):
    assert parse_formula(written, VALUES) == parse_formula(plain)


TOLD = [
    ("x^2 + sen(y)", "line 1, column 7 the unknown function 'sen': did you mean sin?"),
    ("x^2 + Q", "line 1, column 7 the unknown name 'Q': give it a value in \"parameters\""),
    ("x^2 + radios", "did you mean radius?"), ("x + t", "a surface is a formula of x, y, z"), ("x2 + y", "column 1 the unknown name 'x2': did you mean x^2?"),
    ("x\n + y*\n w", "line 3, column 2 the unknown name 'w'"), ("x + ", "ends too early, at line 1, column 3 after '+'"),
    ("(x + 1", "line 1, column 1 '(', which is not closed"), ("x + 1)", "line 1, column 6 ')': that bracket does not fit"),
    ("(x + 1]", "column 7 ']' after the '(' at line 1, column 1"), ("x % 2", "line 1, column 3 the character '%'"), ("x // 2", "floor(a / b)"),
    ("x/2y", "'x/2y' (line 1, column 1) a quotient and an implicit product"), ("x^yz", "an exponent that may end in two places"),
    ("sin x y", "sin with several factors"), ("sin^-1(x)", "asin"), ("x 2", "the number 2 after 'x'"), ("sin + x", "write the argument of sin in brackets"),
    ("max(x)", "column 1 max 1 argument(s); it takes 2 or more"), ("x = y = z", "column 7 a second '='"), ("x < 1 and y = 2", "an equation stands alone"),
    ("x*(y < 1)", "a condition in the place of a number"), ("|x", "a bar without its partner"), ("1,5x", "commas stand between the arguments"),
    ("a = x; a = y; a", "a second value"), ("x + 1; y", "neither the last nor a helper line"), ("x = 1; y", "neither the last nor a helper line"),
    ("sin = x; y", "defines at line 1, column 1 the function 'sin'"), ("g(x,y,z) = x; y", "helper lines have plain names"), ("", "is empty"),
    ("smin(x, y, 0)", "divides by zero"), ("mod(x, 0)", "divides by zero"), ("x^33", "exponents go from -32 to 32"), ("x^y^", "ends too early")]


@pytest.mark.parametrize("text, told", TOLD)
def test_faults_are_told_with_their_place_and_a_remedy(text, told):
    with pytest.raises(FormulaError) as error:
        parse_formula(text, VALUES)
    assert told in str(error.value) and len(str(error.value).splitlines()) == 1


def test_helper_lines_that_grow_are_refused_in_time():
    """Sixty doublings are 2^60 operations put in."""
    lines = ["a0 = x + y"] + [f"a{k} = a{k - 1}*a{k - 1} + a{k - 1}" for k in range(1, 60)] + ["a59"]
    with pytest.raises(FormulaError, match="more than 500 operations"):
        parse_formula("\n".join(lines))


def _scene(**surface) -> bytes:
    return json.dumps({"camera": {}, "objects": [{"surface": {"type": "expression", **surface}}],
                       "lights": [{"position": [0, 5, 0]}]}).encode()


def test_parameters_are_numbers_of_the_kernel_and_survive_a_scene_file():
    a, b = (parse_scene(_scene(formula="x^2 + y^2 + z^2 = R^2", parameters={"R": R})) for R in (1, 2.5))
    f, g = a.objects[0].surface, b.objects[0].surface
    assert f.family == g.family and (f(0, 0, 2), g(0, 0, 2)) == (3, -2.25) and hash(f) != hash(g)
    again = parse_scene(b.model_dump_json(by_alias=True).encode())
    assert again.objects[0].surface == g and again.hash == b.hash != a.hash
    assert Expression(formula="x - R", parameters={"R": 1.0})(1, 0, 0) == 0
    schema = json.dumps(json_schema())
    assert '"parameters"' in schema and '"values"' not in schema


@pytest.mark.parametrize("parameters, told", [
    ({"x": 1}, "x has another meaning"), ({"sin": 1}, "sin has another meaning"), ({"R": "1"}, "parameters"), ({"2R": 1}, "parameters"),
    ({"R": float("1e300")}, "parameters"), ([1], "parameters")])
def test_parameters_that_are_none_are_refused(parameters, told):
    with pytest.raises(InputError) as error:
        parse_scene(_scene(formula="x - 1", parameters=parameters))
    assert told in str(error.value) and "objects[0].surface" in str(error.value)


WORDS = ["x", "y", "z", "2", ".5", "1e3", "0x1", *"()[]{}+-*/^|!<>=,;~#%", "**", "²", "⁻¹", "||", "&&", "and", "or", "not", "<=", "==", "!=",
         "\n", "\r", "\0", "sin", "max", "smin", "mod", "√", "π", "e", "R", "foo", "let ", "return ", "r", "f(x,y,z)=", "p.x", "·", "−", "é"]


def test_any_row_of_words_is_read_or_refused_in_one_sentence():
    chance, read = random.Random(5), 0
    for _ in range(3000):
        text = chance.choice(["", " "]).join(chance.choices(WORDS, k=chance.randint(1, chance.choice([4, 9, 25, 200]))))
        try:
            parse_formula(text, VALUES)
            read += 1
        except FormulaError as error:
            assert len(str(error).splitlines()) == 1, text
    assert read > 10
