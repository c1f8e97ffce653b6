"""That a command hears of what is to be compiled, before it is, in proportion to what has been recorded."""

import pytest

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.compilation import heard
from raytruth.reference_tracer.tracer.render import render


def announced(formulas: list[str], method: str = "exact", **material) -> list:
    scene = Scene.model_validate_json(Scene.model_validate({
        "camera": {"width": 3, "height": 2}, "lights": ({"position": (1.0, 2.0, 0.0)},),
        "objects": tuple({"surface": {"type": "expression", "formula": f, "center": (0.0, 0.0, 3.0)}, "material": material}
                         for f in formulas)}).model_dump_json(by_alias=True, exclude_none=True))
    found = []
    with heard(found.append):
        render(scene, method, interpret=False)
    return found


def test_more_kinds_of_surfaces_are_more_operations():
    (one,), (three,) = announced(["sin(x)+y"]), announced(["sin(x)+y", "exp(x)-y*z", "cos(x)*z+log(y*y+1)"])
    assert one.kernels == three.kernels == 1
    assert 2 * one.operations < three.operations < 10 * one.operations
    assert 0 < one.seconds[0] < one.seconds[1] < three.seconds[1]


@pytest.mark.parametrize("material, kernels", [({"reflection": 0.5}, 3), ({}, 1)])
def test_generations_have_kernels_of_their_own(material, kernels):
    assert [found.kernels for found in announced(["x*x+y*y-z"], **material)] == [kernels]
