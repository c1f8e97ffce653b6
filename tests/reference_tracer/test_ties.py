"""Decision M4: several objects at one distance, or so near to it that rounding hides their order.

Which object is first is decided by python-flint with 256 bits (certify.precise.Body), for the ray as it is, its floats
taken exactly.
"""

import numpy as np
import pytest
from tracing_support import make_scene, shoot, thing, unit

from raytruth.reference_tracer.certify.precise import Body, triple
from raytruth.reference_tracer.certify.search import precision
from raytruth.reference_tracer.first_hit import METHODS
from raytruth.reference_tracer.scene.placement import is_inside
from raytruth.reference_tracer.tracer.render import HIT, UNDECIDED, render

VOUCHING = [method for method in METHODS if method != "paper"]
LIGHTS = [((2, 3, -1), (1, 1, 1))]
FORWARD = (0, 0, 1)
RED, GREEN = {"color": [1, 0, 0]}, {"color": [0, 1, 0]}

BALL = {  # one ball, as objects of different families
    "sphere": lambda **rest: thing("sphere", (0.1, -0.2, 4), r=1, **rest),
    "ellipsoid": lambda **rest: thing("ellipsoid", (0.1, -0.2, 4), a=1, b=1, c=1, **rest),
    "turned": lambda **rest: thing("sphere", (0.1, -0.2, 4), r=1, rotation={"axis": [1, 2, 3], "degrees": 50}, **rest),
    "formula": lambda **rest: thing("expression", (0.1, -0.2, 4), formula="x*x + y*y + z*z - 1", **rest),
    "root": lambda **rest: thing("expression", (0.1, -0.2, 4), formula="sqrt(x*x + y*y + z*z) - 1",
                                 bounds={"low": [-1.1] * 3, "high": [1.1] * 3}, **rest),
    "world": lambda **rest: thing("expression", formula="(x - 0.1)**2 + (y + 0.2)**2 + (z - 4)**2 - 1", **rest),
    "positive": lambda **rest: thing("expression", (0.1, -0.2, 4), formula="1 - (x*x + y*y + z*z)", inside="positive", **rest),
}


@pytest.mark.parametrize("first, second", [("sphere", "sphere"), ("sphere", "formula"), ("formula", "sphere"),
                                           ("turned", "ellipsoid"), ("ellipsoid", "turned"), ("root", "sphere"),
                                           ("sphere", "root"), ("world", "sphere"), ("root", "root"),
                                           ("sphere", "positive"), ("positive", "formula")])
def test_M4_of_one_ball_twice_the_first_is_seen_and_its_pixels_are_undecided(first, second):
    scene = make_scene(BALL[first](material=RED), BALL[second](material=GREEN), lights=LIGHTS, size=(32, 24),
                       camera={"fov": 35})
    alone = render(make_scene(BALL[first](material=RED), lights=LIGHTS, size=(32, 24), camera={"fov": 35}))
    picture = render(scene)
    hit = alone.index == 0
    assert 100 < hit.sum() < 700
    assert np.array_equal(picture.index, alone.index)
    assert np.all(picture.status[hit] == UNDECIDED) and np.array_equal(picture.status[~hit], alone.status[~hit])
    assert picture.color[..., 0].max() > 0.5 and np.all(picture.color[..., 1] == 0)
    np.testing.assert_allclose(picture.normal[hit], alone.normal[hit], rtol=0, atol=1e-13)


@pytest.mark.parametrize("first, second", [("sphere", "sphere"), ("formula", "formula"), ("root", "root")])
def test_M4_the_literal_method_takes_the_first_of_two_equal_objects_and_decides(first, second):
    """One f gives one t, to the last bit: what is equal is told by the scene's order."""
    picture = render(make_scene(BALL[first](material=RED), BALL[second](material=GREEN), lights=LIGHTS, size=(32, 24),
                                camera={"fov": 35}), "paper")
    assert set(np.unique(picture.index)) == {-1, 0} and set(np.unique(picture.status)) == {0, HIT}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kinds", [("sphere", "formula"), ("formula", "sphere")])
def test_M4_the_order_of_the_scene_counts_and_not_that_of_families_or_clusters(method, kinds):
    """Forty balls apart, more than a kernel unrolls, so that they are sorted by place and visited cluster by cluster;
    then all of them once more."""
    random = np.random.default_rng(5)
    places = random.permutation([(x, y, 6) for x in range(-4, 4) for y in range(-2, 3)])
    make = {"sphere": lambda c: thing("sphere", c, r=0.25),
            "formula": lambda c: thing("expression", c, formula="x**2 + y**2 + z**2 - 0.0625",
                                       bounds={"low": [-0.25] * 3, "high": [0.25] * 3})}
    balls = [make[kind](c.tolist()) for kind in kinds for c in places]
    d = unit(places + random.uniform(-0.15, 0.15, (40, 3)))
    found = shoot(make_scene(*balls, step_size=0.05), (0, 0, 0), d, method)
    assert found.index.tolist() == list(range(40)) or (method == "paper" and np.all(found.index % 40 == np.arange(40)))
    assert np.all(found.undecided == (method != "paper"))
    twice = make_scene(*balls[:40], *balls[:40], step_size=0.05)
    assert shoot(twice, (0, 0, 0), d, method).index.tolist() == list(range(40))


@pytest.mark.parametrize("method", VOUCHING)
def test_M4_coplanar_faces(method):
    """A table's top level with a floor, and a plane turned into another: the floor is the first, then the table."""
    floor = thing("plane", (0, -1, 0), a=0, b=1, c=0)
    table = thing("expression", (0, -1.5, 5), formula="max(max(abs(x), abs(z)) - 2, abs(y) - 0.5)",
                  bounds={"low": [-2, -0.5, -2], "high": [2, 0.5, 2]})
    turned = thing("plane", (3, -1, 2), a=0, b=0, c=1, rotation={"axis": [1, 0, 0], "degrees": -90})
    d = unit(np.array([0.0, -1.0, 5.0]) + np.random.default_rng(1).uniform(-0.9, 0.9, (50, 3)) * (1, 0, 1))
    for objects in ((floor, table), (table, floor), (floor, turned), (turned, table, floor)):
        found = shoot(make_scene(*objects), (0, 0, 0), d, method)
        assert np.all(found.index == 0) and np.all(found.undecided)


@pytest.mark.parametrize("method", VOUCHING)
@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 2, 1, 0), (2, 0, 3, 1)])
def test_M4_in_the_corner_of_a_room_the_first_of_all_that_meet_there_counts(method, order):
    """Three walls and the corner of a box meet in (3, 2, 5). Off it by 1e-9 two or three are left, off by more one."""
    walls = [thing("plane", (3, 0, 0), a=-1, b=0, c=0), thing("plane", (0, 2, 0), a=0, b=-1, c=0),
             thing("plane", (0, 0, 5), a=0, b=0, c=-1),
             thing("expression", (0, 0, 0), formula="max(max(abs(x) - 3, abs(y) - 2), abs(z) - 5)", inside="positive")]
    place = [order.index(k) for k in range(4)]  # of each wall in the scene
    scene = make_scene(*(walls[k] for k in order))
    d = unit([(3, 2, 5), (3, 2, 4), (3, 1, 5), (1, 2, 5), (3, 1, 1), (1, 2, 1), (1, 1, 5)])
    meeting = [(0, 1, 2, 3), (0, 1, 3), (0, 2, 3), (1, 2, 3), (0, 3), (1, 3), (2, 3)]
    found = shoot(scene, (0, 0, 0), d, method)
    assert found.index.tolist() == [min(place[k] for k in walls) for walls in meeting] and np.all(found.undecided)
    without = make_scene(*(walls[k] for k in order if k < 3))
    near = unit(d[:, None] + np.array([(1e-9, 0, 0), (0, 1e-9, 0), (0, 0, 1e-9)])).reshape(-1, 3)
    corner = shoot(without, (0, 0, 0), near, method)
    right = [k for k in order if k < 3]
    exact = np.argmin(np.stack([np.divide(w, near[:, k]) for k, w in enumerate((3, 2, 5))], axis=1), axis=1)
    decided = ~corner.undecided
    assert 9 <= decided.sum() < len(near)
    assert [right[k] for k in corner.index[decided]] == exact[decided].tolist()


def _exact_distances(scene, o, d):
    """(objects, rays): each object's first crossing as a ball of 256 bits."""
    with precision(256 + 64):
        bodies, limit = [Body(obj) for obj in scene.objects], scene.tracing.max_distance
        return [[body.line(triple(p), triple(v), is_inside(obj, p), limit, only_first=True).first for p, v in zip(o, d)]
                for body, obj in zip(bodies, scene.objects)]


NEAR = {  # objects whose distances differ by about `gap`
    "spheres": lambda gap: [thing("sphere", (0, 0, 5), r=1 - gap), thing("sphere", (0, 0, 5), r=1)],
    "sphere and formula": lambda gap: [thing("expression", (0, 0, 5), formula="x*x + y*y + z*z - 1"),
                                       thing("sphere", (0, 0, 5 + gap), r=1)],
    "planes": lambda gap: [thing("plane", (0, 0, 4 + gap), a=0.1, b=0.2, c=-1), thing("plane", (0, 0, 4), a=0.1, b=0.2, c=-1)],
    "turned": lambda gap: [thing("plane", (0, 0, 4 + gap), a=-0.3, b=0.1, c=-1),
                           thing("plane", (0, 0, 4), a=0.1, b=0.3, c=-1, rotation={"axis": [0, 0, 1], "degrees": 90})],
    "torus and quartic": lambda gap: [
        thing("torus", (0, 0, 5), R=1, r=0.5 - gap, rotation={"axis": [1, 0, 0], "degrees": 37}),
        thing("expression", (0, 0, 5), formula="(x**2 + y**2 + z**2 + 0.75)**2 - 4*(x**2 + y**2)",
              rotation={"axis": [1, 0, 0], "degrees": 37}, bounds={"low": [-1.5, -1.5, -0.5], "high": [1.5, 1.5, 0.5]})],
    "three": lambda gap: [thing("sphere", (0, 0, 5), r=1 - gap), thing("ellipsoid", (0, 0, 5), a=1, b=1, c=1),
                          thing("expression", (0, 0, 5), formula="x**2 + y**2 + z**2 - 1")],
}


@pytest.mark.parametrize("name", NEAR)
@pytest.mark.parametrize("gap", [1e-9, 1e-12, 1e-13, 1e-14, 3e-15, 1e-15, 4.5e-16, 0.0])
def test_M4_what_is_decided_of_near_ties_is_right(name, gap):
    """Undecided rays show the first in scene order of all that come within rounding of the nearest."""
    scene = make_scene(*NEAR[name](gap))
    random = np.random.default_rng(11)
    d = unit(np.column_stack([random.uniform(-0.18, 0.18, (60, 2)), np.ones(60)]))
    o = np.broadcast_to(np.zeros(3), d.shape)
    t = _exact_distances(scene, o, d)
    found = shoot(scene, o, d)
    off = np.array([[np.inf if row[k] is None else max(0.0, float(row[k] - min(x for x in column if x is not None)))
                     for k, column in enumerate(zip(*t)) if found.index[k] >= 0] for row in t])
    met = found.index >= 0
    assert met.sum() > 20 and np.all(found.undecided[met] | (off[found.index[met], np.arange(met.sum())] == 0))
    for index, undecided, away in zip(found.index[met], found.undecided[met], off.T):
        if undecided:
            assert away[index] < 1e-12 and not np.any(away[:index] == 0)
        else:
            assert np.sum(away == 0) == 1
    if name != "three":
        share = found.undecided[met].mean()
        assert share < 0.1 if gap >= 1e-12 else share == 1 if gap == 0 else True


def test_M4_rays_far_from_any_tie_stay_decided():
    """Two balls that overlap: no pixel centre lies on the circle where they meet."""
    picture = render(make_scene(thing("sphere", (-0.5, 0.1, 5), r=1), thing("sphere", (0.5, 0, 5), r=1), size=(64, 48)))
    assert {0, 1} <= set(np.unique(picture.index)) and not np.any(picture.status == UNDECIDED)


@pytest.mark.parametrize("method", VOUCHING)
def test_M4_an_object_just_beyond_the_end_of_a_ray_ties_with_nothing(method):
    walls = [thing("plane", (0, 0, 30 + 1e-9), a=0, b=0, c=-1), thing("plane", (0, 0, 30 + 2e-9), a=0, b=0, c=-1)]
    found = shoot(make_scene(*walls), (0, 0, 0), FORWARD, method)
    assert found.index.tolist() == [-1] and found.undecided.tolist() == [False]
