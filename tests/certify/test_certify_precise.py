"""The 77-digit tracer against closed forms in exact or 70-digit decimal arithmetic."""

from decimal import Decimal, getcontext

import pytest
from certify_support import make_scene, thing
from flint import arb, ctx, fmpq

from raytruth.reference_tracer.certify.precise import Decision, PreciseTracer
from raytruth.reference_tracer.certify.records import NOTHING, PRIMARY, REFLECTION, REFRACTION

getcontext().prec = 70


def _equal(color, expected, digits: int = 65) -> bool:
    with ctx.workprec(300):
        return abs(color - arb(str(expected) if isinstance(expected, Decimal) else expected)) < arb(10)**-digits


def test_a_ball_lit_from_the_camera_has_the_cosine_of_its_impact_parameter():
    """The light is the camera: cos(phi) = -d . normal = sqrt(1 - b^2/r^2), b the distance of the ray from the ball's
    centre at distance 3: b^2 = 9 (1 - cos^2 of the angle to the axis) = 9 q/(1 + q), q = x^2 + y^2 on the canvas. A
    pixel of a 9 x 9 picture with fov 60 is 2 tan(30 degrees)/9 wide, so q = (4/3)/81 (i^2 + j^2); here with 2 x 2
    samples, at quarter pixels."""
    scene = make_scene(thing("sphere", (0, 0, 3), {"color": (1, 0.5, 0.25)}, r=1), lights=(((0, 0, 0), 0.5),),
                       size=(9, 9), samples=2)
    path = PreciseTracer(scene).pixel(3, 5)
    expected = Decimal(0)
    for i in (Decimal("0.75"), Decimal("1.25")):  # row 3 is one above the middle, column 5 one to the right
        for j in (Decimal("0.75"), Decimal("1.25")):
            q = Decimal(4) / 3 / 81 * (i * i + j * j)
            expected += (1 - 9 * q / (1 + q)).sqrt() / 2 / 4
    for channel, share in zip(path.color, (1, Decimal("0.5"), Decimal("0.25"))):
        assert _equal(channel, expected * share)
    assert path.decisions == {Decision(0, PRIMARY, 0, (1.0,)): 4} and path.rays == 8


def test_a_corridor_of_two_mirrors_is_a_geometric_series():
    """Both walls reflect R = 1/2 and are lit head-on from the camera: each bounce adds (1 - R) R^k times the light, the
    last secondary ray sees the background (D1)."""
    wall = {"reflection": 0.5}
    scene = make_scene(thing("plane", (0, 0, 2), wall, a=0, b=0, c=-1), thing("plane", (0, 0, -2), wall, a=0, b=0, c=1),
                       lights=(((0, 0, 0), 0.75),), size=(3, 3), max_depth=5, background=(1, 2, 4))
    path = PreciseTracer(scene).pixel(1, 1)
    for channel, background in zip(path.color, (1, 2, 4)):
        assert channel == arb(sum(fmpq(3, 4) * fmpq(1, 2)**(k + 1) for k in range(6)) + background * fmpq(1, 2)**6)
    assert path.decisions[Decision(3, REFLECTION, 1, (1.0,))] == 1 and sum(path.decisions.values()) == 6


def test_light_through_a_ball_of_glass_loses_its_transparency_twice():
    """Along the axis nothing bends: T^2 of the background, T = 3/4; off it a ray in glass n = 1 runs straight."""
    for n, row in ((1.5, 1), (1.0, 0)):
        glass = {"transparency": 0.75, "refractive_index": n, "color": (0, 0, 0)}
        scene = make_scene(thing("sphere", (0, 0, 3), glass, r=1), size=(3, 3), fov=40, background=(1, 0.5, 0.25))
        path = PreciseTracer(scene).pixel(row, 1)
        assert [_equal(c, fmpq(9, 16) * fmpq(b)) for c, b in zip(path.color, (1, fmpq(1, 2), fmpq(1, 4)))] == [True] * 3
        assert sorted((d.generation, d.kind, d.index) for d in path.decisions) == [
            (0, PRIMARY, 0), (1, REFRACTION, 0), (2, REFRACTION, NOTHING)]


def test_a_shadow_through_glass_keeps_the_square_of_its_transparency():
    """L3: the ray to the light above crosses the ball twice; straight below the light the floor has cos(phi) = 1."""
    glass = {"transparency": 0.5, "refractive_index": 1.5}
    scene = make_scene(thing("plane", (0, 0, 4), {}, a=0, b=0, c=-1), thing("sphere", (0, 0, 2), glass, r=0.5),
                       lights=(((0, 0, 1), 1.0),), size=(3, 3), fov=90)
    tracer = PreciseTracer(scene)
    tracer.v_pos = (arb(0), arb(0), arb(3))  # between ball and wall
    path = tracer.pixel(1, 1)
    assert path.color[0] == arb(0.25) and path.decisions == {Decision(0, PRIMARY, 0, (0.25,)): 1}


@pytest.mark.parametrize("degrees, axis", [(90, (0, 0, 1)), (180, (1, 1, 0)), (33, (1, 2, -0.5))])
def test_a_turned_ball_looks_the_same(degrees, axis):
    """Rodrigues' formula: a rotation about its centre leaves a ball alone, whatever its digits."""
    plain, turned = (thing("sphere", (0.25, 0.5, 3), r=1, rotation=rotation)
                     for rotation in (None, {"axis": list(axis), "degrees": degrees}))
    a, b = (PreciseTracer(make_scene(ball)).pixel(8, 13) for ball in (plain, turned))
    assert a.color[0] > 0.1 and _equal(a.color[0] - b.color[0], 0, 60)
