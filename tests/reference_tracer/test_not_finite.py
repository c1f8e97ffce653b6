"""A formula that is nowhere finite: every method ends, and those that vouch say "undecided" (decision M7)."""

import json
import math
import subprocess
import sys

import drjit as dr
import numpy as np
import pytest
from drjit.llvm import Float64

from raytruth.reference_tracer.numbers import functions as fn
from raytruth.reference_tracer.surfaces.exact_polynomial import polynomial, tree_of
from raytruth.reference_tracer.surfaces.formula import FormulaError
from raytruth.reference_tracer.surfaces.formula_parser import parse_formula

NOWHERE = ("0**x", "1/(0**x)", "((0)**x)**-1", "(0*x)**-0.5", "(0*x)**x", "exp(1e5+x*0)", "max(x, sqrt(-1-x*x))",
           "exp(log(-1-x*x))-1", "x-exp(log(-1-x*x))", "1-2**log(-1-x*x)", "0.5**(log(-1-abs(x)))-1", "log(-exp(x))")
METHODS = ("paper", "exact", "interval", "proof", "descartes")
UNENDING = 300.0  # seconds; all of them together take less than ten

PROGRAM = """
import json, sys
from raytruth.reference_tracer.tracer.render import render
from raytruth.reference_tracer.scene.model import Scene
formulas, methods = json.loads(sys.argv[1])
for formula in formulas:
    scene = Scene.model_validate_json(json.dumps({"camera": {"width": 3, "height": 2}, "objects": [
        {"surface": {"type": "expression", "formula": formula, "center": [0, 0, 3]}}], "lights": [{"position": [1, 2, 0]}]}))
    print(json.dumps([formula, [sorted(set(render(scene, method).status.ravel().tolist())) for method in methods]]))
"""


def test_methods_end_undecided_where_f_is_nowhere_finite():
    """In a process of its own: a kernel that never ends can only be ended with its process."""
    told = subprocess.run([sys.executable, "-c", PROGRAM, json.dumps([NOWHERE, METHODS])], timeout=UNENDING,
                          capture_output=True, text=True, check=True).stdout
    found = dict(map(json.loads, told.splitlines()))
    assert found == {formula: [[0], [2], [2], [2], [2]] for formula in NOWHERE}  # the literal method sees "outside"


@pytest.mark.parametrize("function", [fn.exp, fn.sin, fn.cos, fn.tan, fn.cbrt, fn.sqrt, fn.log, fn.absolute,
                                      lambda x: fn.power(x, 2.3), lambda x: fn.power(x, -0.5), lambda x: fn.power(1.7, x)])
@pytest.mark.parametrize("nan", [lambda x: x * math.nan, lambda x: x * 0 + math.nan, lambda x: dr.sqrt(-1 - abs(x)),
                                 lambda x: dr.log(x - x - 1) * x])
def test_a_nan_that_the_compiler_sees_stays_one(function, nan):
    """LLVM takes a NaN made a whole number for anything: drjit.exp(x * nan) is 0, or what stands in memory."""
    x = dr.opaque(Float64, 1.0, 4) * dr.arange(Float64, 4)
    value = function(nan(x))
    dr.eval(value)  # in one kernel with the argument
    assert np.isnan(value.numpy()).all()


def test_constants_beyond_the_largest_float_are_refused_in_a_sentence():
    for formula in ("(x*0+1e308)*1e10", "x-x-1e300*1e300*(x**0)"):
        with pytest.raises(FormulaError, match="no finite number|without a finite value"):
            parse_formula(formula)


def test_coefficients_that_are_beyond_the_largest_float_times_another():
    p = polynomial(parse_formula("1e-300*x*x+1e300*y*y+1e300*x-1"))
    assert polynomial(tree_of(p)).total_degree() == 2
