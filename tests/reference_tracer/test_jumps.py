"""Decision M8: where f jumps across zero a ray crosses, and there is no normal; a jump on one side of zero is nothing."""

import numpy as np
import pytest
from tracing_support import make_scene, shoot, thing

from raytruth.reference_tracer.certify.line import follow
from raytruth.reference_tracer.surfaces import Expression
from raytruth.reference_tracer.tracer.render import UNDECIDED, render

BALL = "x^2 + y^2 + (z - 5)^2 - 1"


def _rays(n=300):
    random = np.random.default_rng(2)
    o = random.uniform(-1, 1, (n, 3)) * (1, 1, 0.2)
    d = np.array([0.0, 0.0, 5.0]) + random.uniform(-1.2, 1.2, (n, 3)) - o
    return o, d / np.linalg.norm(d, axis=1)[:, None]


@pytest.mark.parametrize("wall", ["0.5 - step(4, z)", "sign(4 - z)", "x/9 + 2 - 4*step(4, z)", "3.5 - floor(z)",
                                  "atan2(4 - z, -1 - x^2)", "1 - 2mod(floor((z + 1)/5), 2)"])
@pytest.mark.parametrize("method", ["exact", "interval", "proof"])
def test_M8_a_ray_that_ends_at_a_jump_is_undecided(wall, method):
    """All of them cross to the inside at z = 4, from any side; no method may decide what is seen there."""
    o, d = _rays()
    scene = make_scene(thing("expression", formula=f"{wall} + 0*x"))
    assert (scene.objects[0].surface(o.T[0], o.T[1], o.T[2]) > 0).all()
    assert shoot(scene, o, d, inside=[False], method=method).undecided.all()


@pytest.mark.parametrize("jump", ["0.5*step(9, z)", "0.4*floor(z/9)", "0.3*(1 - sign(3 - y))", "mod(x, 1)*0",
                                  "0.5*max(0, sign(x^2 + y^2 + (z - 5)^2 - 2))"])
def test_M8_a_jump_on_one_side_of_zero_is_nothing(jump):
    o, d = _rays()
    ball, with_jump = (shoot(make_scene(thing("expression", formula=f)), o, d, inside=[False]) for f in (BALL, f"{BALL} + {jump}"))
    np.testing.assert_array_equal(with_jump.index, ball.index)
    hit = ball.index == 0
    assert not with_jump.undecided.any() and 50 < hit.sum() < 300
    np.testing.assert_allclose(with_jump.t[hit], ball.t[hit], rtol=1e-13)


def test_M8_shadow_rays_count_a_jump():
    """A slab of the air between y = 2 and 2.5 lies before the light; the camera sees the floor only."""
    slab = thing("expression", formula="0.5 - step(2, y)*step(-2.5, -y)")
    floor = thing("plane", (0, -1, 0), a=0, b=1, c=0)
    seen_from = {"lights": [((0, 6, 2), (1, 1, 1))], "size": (24, 16), "camera": {"direction": [0, -1, 1]}}
    picture, plain = (render(make_scene(*objects, **seen_from), "exact") for objects in ((floor, slab), (floor,)))
    seen = (plain.index == 0) & (plain.color.max(axis=-1) > 0)
    assert seen.sum() > 100
    assert (picture.status[seen] != UNDECIDED).all() and (picture.color[seen] == 0).all()


def test_M8_exact_arithmetic_decides_no_ray_through_a_jump():
    wall = Expression(formula="0.5 - step(4, z) + 0*x")
    assert follow(wall, (0.1, 0.2, 0.0), (0.0, 0.1, 1.0), False, 9.0).undecided
    aside = Expression(formula=f"{BALL} + 0.5*step(9, z)")
    found = follow(aside, (0.1, 0.2, 0.0), (0.0, 0.0, 1.0), False, 20.0)
    assert not found.undecided and float(found.first) == pytest.approx(5 - np.sqrt(1 - 0.05), rel=1e-14)
