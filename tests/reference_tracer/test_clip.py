"""`clip`: the solid is f < 0 and inside the box (f > 0 where that is inside), for every surface and method alike."""

import json

import numpy as np
import pytest
from tracing_support import make_scene, random_rays, shine, shoot, thing, unit

from raytruth.reference_tracer.certify import certify
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.oracle import literal
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Object, Scene, json_schema
from raytruth.reference_tracer.scene.placement import rotation_matrix
from raytruth.reference_tracer.surfaces import Bounds, Clipped, Sphere
from raytruth.reference_tracer.tracer.render import render

TURN = {"axis": [1, 2, -0.5], "degrees": 33}
UPPER = {"low": [-2, -2, 0], "high": [2, 2, 2]}
CUBE = {"low": [-1, -1, -1], "high": [1, 1, 1]}


def intervals_of_box(o, d, box):
    """(t0, t1): where lines are within the box; t0 > t1 where they pass by (Kay and Kajiya)."""
    with np.errstate(divide="ignore"):
        ends = (np.array([box["low"], box["high"]])[:, None] - o) / d
    return ends.min(axis=0).max(axis=-1), ends.max(axis=0).min(axis=-1)


def chord(a, b, c):
    """The roots of a t^2 + 2 b t + c where it is negative between them."""
    root = np.sqrt(np.maximum(b * b - a * c, 0))
    real = b * b > a * c
    return np.where(real, (-b - root) / a, np.inf), np.where(real, (-b + root) / a, -np.inf)


def dot(a, b):
    return np.einsum("...j,...j->...", a, b)


def of_plane(o, d):  # z < 0.25 x
    g, slope = o @ [-0.25, 0, 1], d @ [-0.25, 0, 1]
    t = -g / slope
    return np.where(slope > 0, -np.inf, t), np.where(slope > 0, t, np.inf)


def of_paraboloid(o, d):  # x^2 + y^2 < z
    return chord(dot(d[:, :2], d[:, :2]), dot(o[:, :2], d[:, :2]) - d[:, 2] / 2, dot(o[:, :2], o[:, :2]) - o[:, 2])


def of_ball(o, d):
    return chord(dot(d, d), dot(o, d), dot(o, o) - 1)


SOLIDS = {  # the surface, its clip box, and the part of a line within the solid without its clip, which is one interval
    "plane": (thing("plane", a=-0.25, b=0, c=1), CUBE, of_plane),
    "paraboloid": (thing("paraboloid", a=1, b=1), {"low": [-2, -2, -1], "high": [2, 2, 1.5]}, of_paraboloid),
    "sphere": (thing("sphere", r=1), UPPER, of_ball),
    "ellipsoid": (thing("ellipsoid", a=1, b=0.5, c=0.8), UPPER, lambda o, d: of_ball(o / [1, 0.5, 0.8], d / [1, 0.5, 0.8])),
    "formula": (thing("expression", formula="x**2 + y**2 - 0.25"), CUBE,
                lambda o, d: chord(dot(d[:, :2], d[:, :2]), dot(o[:, :2], d[:, :2]), dot(o[:, :2], o[:, :2]) - 0.25)),
    "without a degree": (thing("expression", formula="sqrt(x**2 + y**2 + z**2) - 1"), UPPER, of_ball),
    "-f": (thing("expression", formula="1 - x**2 - y**2 - z**2", inside="positive", bounds=CUBE), UPPER, of_ball),
    "box alone": (thing("sphere", r=9), CUBE, lambda o, d: (np.full(len(o), -np.inf), np.full(len(o), np.inf)))}


def clipped(document: dict, box: dict, **rest) -> dict:
    return document | {"surface": document["surface"] | {"clip": box}} | rest


@pytest.mark.parametrize("method", ["paper", "exact", "interval", "proof", "descartes"])
@pytest.mark.parametrize("name", SOLIDS)
def test_a_convex_solid_is_met_where_line_and_box_say(name, method):
    """Turned and moved; the interval of a line in the solid is that in f < 0 and in the box together."""
    document, box, within = SOLIDS[name]
    scene = make_scene(clipped(document, box, rotation=TURN), step_size=0.01)
    assert scene.objects[0].surface.sign_outside == 1
    turn = rotation_matrix(scene.objects[0].rotation)
    o, d = random_rays(300, seed=5, spread=1.2)
    starts, ends = zip(within(o @ turn, d @ turn), intervals_of_box(o @ turn, d @ turn, box))
    t0, t1 = np.maximum(*starts), np.minimum(*ends)
    clear = ~(np.abs(t1 - t0) < 0.05)  # neither grazing nor through an edge
    hits = t0 < t1
    found = shoot(scene, o[clear], d[clear], method)
    assert (found.index == np.where(hits[clear], 0, -1)).all() and not found.undecided.any()
    o, d, t0, t1, t = o[hits & clear], d[hits & clear], t0[hits & clear], t1[hits & clear], found.t[hits[clear]]
    assert np.abs(t - t0).max() < 1e-9 and len(t) > 30
    middle, half = o + (0.5 * (t0 + t1))[:, None] * d, 0.5 * (t1 - t0)
    found = shoot(scene, middle, d, method)
    assert np.abs(found.t - half).max() < 1e-9
    assert (shine(scene, middle - 8 * d, d, 16.0, method) == 0).all()


@pytest.mark.parametrize("method", ["paper", "exact", "interval", "proof"])
def test_a_positive_solid_is_what_of_the_box_lies_outside_of_the_ball(method):
    """A cube with a ball of radius 1.2 taken out of it: corners remain. Seen along z: at x = y = 0 nothing is left; at
    x = y = 0.9 the ball is missed (0.9 sqrt 2 > 1.2) and the cube's face is met; at x = 0.9, y = 0 the cube from
    z = -1 to -sqrt(1.44 - 0.81)."""
    scene = make_scene(clipped(thing("sphere", (0, 0, 4), r=1.2, inside="positive"), CUBE), step_size=0.01)
    at = [(0, 0, 0), (0.9, 0.9, 0), (0.9, 0, 0)]
    found = shoot(scene, at, (0, 0, 1), method)
    assert found.index.tolist() == [-1, 0, 0] and found.t[1:] == pytest.approx([3, 3], abs=1e-12)
    inside = shoot(scene, (0.9, 0, 3.1), (0, 0, 1), method)
    assert inside.t == pytest.approx(4 - np.sqrt(1.44 - 0.81) - 3.1, abs=1e-9)


def test_normals_belong_to_the_part_that_is_met():
    """A hemisphere from above its cut, and its round side: the face's normal there, the ball's here."""
    scene = make_scene(clipped(thing("sphere", (0, 0, 4), r=1), {"low": [-2, -2, 0], "high": [2, 2, 2]}),
                       size=(33, 33), camera={"fov": 30})
    picture = render(scene)
    met = picture.index == 0
    assert met.sum() > 100 and np.abs(picture.normal[met] - [0, 0, -1]).max() < 1e-12
    assert picture.position[met][:, 2] == pytest.approx(4)
    behind = render(make_scene(clipped(thing("sphere", (0, 0, 4), r=1), {"low": [-2, -2, -2], "high": [2, 2, 0]}),
                               size=(33, 33), camera={"fov": 30}))
    met = behind.index == 0
    assert np.abs(behind.normal[met] - unit(behind.position[met] - [0, 0, 4])).max() < 1e-9


def test_paper_equals_the_literal_search():
    """Glass and mirrors, clipped; literal.py has no boxes. Where f is not defined nothing is inside (M7)."""
    scene = make_scene(
        clipped(thing("torus", (-0.7, 0, 4), R=0.8, r=0.3, material={"transparency": 0.5, "refractive_index": 1.3},
                      rotation=TURN), {"low": [-2, -2, -2], "high": [0.2, 2, 2]}),
        clipped(thing("expression", (1.2, 0, 5), formula="sqrt(x) + y**2 + z**2 - 1", material={"reflection": 0.5}), CUBE),
        clipped(thing("heart", (0, 1, 4)), {"low": [-2, -2, -0.2], "high": [2, 2, 2]}),
        size=(20, 15), lights=[((2, 3, -1), (1, 1, 1))], max_depth=2, max_distance=12)
    assert np.abs(render(scene, "paper").color - literal.render(scene)).max() < 1e-9


def test_a_clipped_scene_is_certified():
    scene = make_scene(clipped(thing("paraboloid", (0, 0, 3), a=0.5, b=0.7, rotation=TURN), CUBE),
                       clipped(thing("sphere", (0.5, 0.2, 5), r=1), UPPER), size=(24, 18), lights=[((2, 3, -1), (1, 1, 1))])
    certificate = certify(scene, sample=100, paths=4)
    assert certificate.passed and certificate.undecided_rays < 0.02 * certificate.rays


# --- the format ----------------------------------------------------------------------------------------------------
def test_a_clipped_scene_is_written_as_it_was_read():
    document = clipped(thing("torus", (1, 2, 3), R=0.8, r=0.3, inside="positive"), CUBE)
    scene = make_scene(document)
    surface = scene.objects[0].surface
    assert isinstance(surface, Clipped) and surface.type == "clipped torus" and surface.center == (1, 2, 3)
    text = scene.model_dump_json(by_alias=True, exclude_unset=True)
    written = json.loads(text)["objects"][0]["surface"]
    assert written == json.loads(json.dumps(document["surface"]))
    again = parse_scene(text.encode())
    assert again == scene and again.hash == scene.hash
    plain = make_scene(thing("torus", (1, 2, 3), R=0.8, r=0.3, inside="positive"))
    assert plain.hash != scene.hash and "clip" not in plain.model_dump_json()
    schema = json.dumps(json_schema())
    assert '"clip"' in schema and "Clipped" not in schema


def test_it_is_made_of_python_objects_too():
    clip = Bounds(low=(0.0, 0.0, 0.0), high=(1.5, 1.5, 0.5))
    scene = Scene(objects=(Object(surface=Sphere(r=1.0, clip=clip)),))
    assert scene.objects[0].surface.box() == ((0, 0, 0), (1, 1, 0.5))  # no larger than the ball
    hollow = Scene(objects=(Object(surface=Sphere(r=1.0, inside="positive", clip=clip)),))
    assert hollow.objects[0].surface.box() == clip.corners


def test_clip_heals_what_bounds_would_break():
    """The remedy that the refusal names."""
    cut = {"low": [-0.8] * 3, "high": [0.8] * 3}
    quartic = thing("expression", (0, 0, 4), formula="x**4 + y**4 + z**4 - 1")
    with pytest.raises(InputError, match='"clip"'):
        make_scene(quartic | {"surface": quartic["surface"] | {"bounds": cut}})
    scene = make_scene(clipped(quartic, cut))
    assert shoot(scene, (0, 0, 0), (0, 0, 1)).t == pytest.approx(3.2, abs=1e-12)


@pytest.mark.parametrize("box, message", [
    ({"low": [0, 0, 0], "high": [1, 0, 1]}, "must be smaller"), ({"low": [0, 0, 0]}, "is missing"), (3, "object in braces")])
def test_impossible_boxes(box, message):
    with pytest.raises(InputError, match=message):
        make_scene(clipped(thing("sphere", r=1), box))
