"""On which side of an object the camera stands, also where f has no value there (decisions M3 and M7)."""

import numpy as np
import pytest
from tracing_support import make_scene, thing

from raytruth.reference_tracer.scene.placement import is_inside
from raytruth.reference_tracer.tracer.render import render

# the camera's position, in the surface's own frame, is (0, 0, -3)
AT_THE_CAMERA = {
    "y / max(y, z)": False,  # 0 / 0
    "z / abs(x)": False,  # -inf
    "1 / min(x, y)": False,  # inf
    "log(x) - sqrt(z)": False,  # -inf - NaN
    "z / cbrt(y) + 1 / y": False,  # -inf + inf
    "z + 1 / max(1, x)": True,  # -3 + 1
    "min(z / abs(x), 1) * 0 - 1": False,  # -inf * 0
}


@pytest.mark.parametrize("formula, inside", AT_THE_CAMERA.items())
def test_M7_the_side_of_a_camera_where_f_has_no_value_is_outside(formula, inside):
    scene = make_scene(thing("expression", (0, 0, 3), formula=formula), size=(4, 3))
    assert is_inside(scene.objects[0], (0, 0, 0)) is inside
    assert np.isfinite(render(scene, "paper").color).all()


def test_a_formula_without_coordinates_has_a_side_too():
    scene = make_scene(thing("expression", (0, 0, 3), formula="-1 + 0*sin(x)"), thing("expression", formula="2 - cos(0) - 3 + 0*sin(x)"))
    assert [is_inside(o, (0, 0, 0)) for o in scene.objects] == [True, True]
