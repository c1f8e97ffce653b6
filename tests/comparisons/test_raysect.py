"""raysect against the exact reference: roots of another team's code; what it has no primitive for, and its absence, are told."""

import json

import numpy as np
import pytest

import raytruth as rt
from raytruth.cli import main
from raytruth.comparisons.renderers import raysect
from raytruth.comparisons.verdicts import metrics
from raytruth.converters import raysect as converter
from raytruth.converters.crossings import Start
from raytruth.reference_tracer.errors import MissingError, UnsupportedError
from raytruth.reference_tracer.scene.model import Tracing

needs_raysect = pytest.mark.skipif(converter.World is None, reason="raysect is not installed")
TURN = rt.Rotation(axis=(1.0, 0.4, 0.2), degrees=35.0)
BOX = rt.Bounds(low=(-2.0, -2.0, -0.5), high=(2.0, 0.3, 2.0))
FLOOR = rt.Plane(center=(0.0, -1.0, 0.0), a=0.1, b=1.0, c=0.05)


def thing(surface, rotation=None, **material):
    return rt.Object(surface=surface, rotation=rotation, material=rt.Material(**material))


def scene(*objects, **parts):
    lights = (rt.Light(position=(2.0, 5.0, -1.0), brightness=(0.6, 0.6, 0.5)), rt.Light(position=(-3.0, 4.0, 2.0)))
    return rt.Scene(**{"name": "witnessed", "objects": objects, "camera": rt.Camera(width=48, height=36), "lights": lights,
                       "background": (0.1, 0.2, 0.3), **parts})


ALONE = {
    "plane": thing(FLOOR), "sphere": thing(rt.Sphere(center=(0.3, 0.2, 4.0), r=1.1)),
    "ellipsoid": thing(rt.Ellipsoid(center=(0.2, 0.2, 5.0), a=1.0, b=0.5, c=1.7), TURN),
    "torus": thing(rt.Torus(center=(0.0, 0.2, 4.0), R=0.8, r=0.4), TURN),
    "paraboloid": thing(rt.Paraboloid(center=(0.0, -0.5, 6.0), a=0.9, b=0.6), TURN),
    "a room": thing(rt.Sphere(center=(0.3, 0.1, 0.2), r=6.0, inside="positive")),
    "a paraboloid cut": thing(rt.Paraboloid(center=(0.0, 0.0, 4.0), a=1.0, b=0.7, clip=BOX), TURN),
    "half a torus": thing(rt.Torus(center=(0.0, 0.2, 4.0), R=0.9, r=0.4, clip=BOX), TURN),
    "a box less a ball": thing(rt.Sphere(center=(0.0, 0.2, 4.0), r=1.2, inside="positive", clip=BOX), TURN),
    "a wedge": thing(rt.Plane(center=(0.0, 0.2, 4.0), a=1.0, b=0.5, c=-1.0, clip=BOX), TURN)}
TOGETHER = {
    "glass, a mirror and shadows": scene(
        thing(FLOOR, reflection=0.3, color=(0.8, 0.8, 0.7)), thing(rt.Torus(center=(1.0, 0.3, 4.5), R=0.8, r=0.3), TURN, color=(0.2, 0.3, 0.9)),
        thing(rt.Sphere(center=(-0.6, 0.0, 3.5), r=0.8), transparency=0.8, refractive_index=1.4, reflection=0.1)),
    "cut glass": scene(thing(FLOOR), thing(rt.Sphere(center=(0.0, 0.1, 3.5), r=0.9, clip=BOX), TURN, transparency=0.7, refractive_index=1.3),
                       tracing=Tracing(max_depth=4))}


@needs_raysect
@pytest.mark.parametrize("name", ALONE)
def test_first_hits_are_the_references(name):
    of = scene(ALONE[name])
    theirs, ours = raysect.render(of), rt.render(of)
    found = metrics.geometry(*({**vars(p), "camera": np.array(of.camera.position)} for p in (ours, theirs)))
    assert found["object mismatches"] == 0 and found["hit pixels"] > 100
    assert found["depth max"] < 1e-12 and found["normal max degrees"] < 1e-8


@needs_raysect
@pytest.mark.parametrize("name", TOGETHER)
def test_whole_pictures_agree_and_a_wrong_radius_does_not(name, tmp_path):
    """Its limit is double precision's: 1e-8 of a radius is far beyond it."""
    of = TOGETHER[name]
    truth, theirs = rt.render(of), raysect.render(of)
    found = rt.compare(truth, theirs, tmp_path)
    assert found.verdict == "agrees" and found.metrics["color max"] < 1e-9, found.reason
    last = of.objects[-1]
    surface = rt.Sphere(center=last.surface.center, clip=last.surface.clip, r=(0.9 if name == "cut glass" else 0.8) * (1 + 1e-8))
    wrong = of.model_copy(update={"objects": (*of.objects[:-1], rt.Object(surface=surface, rotation=last.rotation, material=last.material))})
    theirs = raysect.render(wrong)
    assert rt.compare(truth, rt.Picture(**{**vars(theirs), "scene": of}), tmp_path).verdict == "differs"


@needs_raysect
@pytest.mark.parametrize("R, r", [(0.8, 0.3), (0.8, 0.05), (1.0, 0.9), (30.0, 4.0)])
def test_roots_of_a_torus_keep_the_stated_error_from_near_and_far(R, r):
    """The closed form of the distance at hits of rays towards points of the torus. From afar alone, raysect keeps no such error."""
    of, rng = scene(thing(rt.Torus(R=R, r=r))), np.random.default_rng(11)
    tracer, stated = converter.RaysectIntersector(of.traced_with(max_distance=1e4, step_size=1.0)), converter.error(of.objects[0].surface)

    def off(distance, ahead=True):
        phi, theta = rng.uniform(0, 2 * np.pi, (2, 4000))
        q = np.stack([(R + r * np.cos(theta)) * np.cos(phi), (R + r * np.cos(theta)) * np.sin(phi), r * np.sin(theta)], axis=1)
        o = rng.normal(size=(4000, 3))
        o *= distance * (R + r) / np.linalg.norm(o, axis=1, keepdims=True)
        d = (q - o) / np.linalg.norm(q - o, axis=1, keepdims=True)
        if not ahead:
            tracer.solids[0].radius = np.inf
        t = tracer.first_hit(Start(o, np.full(4000, -1), np.zeros((4000, 3))), d, np.zeros((4000, 1), bool)).t
        assert np.isfinite(t).mean() > 0.999  # a ray that only grazes it may miss
        p = (o + t[:, None] * d)[np.isfinite(t)]
        return np.abs(np.hypot(np.hypot(p[:, 0], p[:, 1]) - R, p[:, 2]) - r).max() - 4e-16 * distance * (R + r)

    measured = [off(distance) for distance in (1.5, 5.0, 40.0)]
    assert max(measured) <= stated and max(measured) > stated / 1000, measured
    assert off(40.0, ahead=False) > stated


@needs_raysect
def test_a_wrong_side_is_noticed(monkeypatch):
    """Without inherited sides (M3), rays stop at the surface that they start on."""
    of, right = TOGETHER["glass, a mirror and shadows"], rt.render(TOGETHER["glass, a mirror and shadows"])

    def crossings(self, o, d, ahead, inside, end):
        found = self.primitive.hit(converter.Ray(converter.Point3D(*o), converter.Vector3D(*d), end))
        while found is not None:
            yield found.ray_distance, found
            found = self.primitive.next_intersection()

    monkeypatch.setattr(converter.Solid, "crossings", crossings)
    assert np.quantile(np.abs(raysect.render(of).color - right.color), 0.9) > 0.01


@needs_raysect
@pytest.mark.parametrize("surface, what", [
    (rt.Heart(center=(0.0, 0.0, 4.0)), "raysect has no primitive for heart, a heart"),
    (rt.Expression(formula="x+y"), "no primitive for expression"),
    (rt.Torus(center=(0.0, 0.0, 4.0), R=0.5, r=0.8), "a torus that overlaps itself")])
def test_what_it_has_no_primitive_for_is_refused(surface, what):
    with pytest.raises(UnsupportedError, match=what):
        raysect.render(scene(thing(surface)))


def test_its_absence_is_one_sentence(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(converter, "World", None)
    with pytest.raises(MissingError, match="raysect is not installed; it is optional"):
        raysect.render(scene(ALONE["sphere"]))
    assert main(["render", "figure-05-sphere", "--with", "raysect", "-o", str(tmp_path / "a.npz")]) == 2
    assert "raytruth: raysect is not installed; it is optional ('pip install raysect' brings it)\n" in capsys.readouterr().err
    main(["doctor", "--json"])
    told = {finding["name"]: finding for finding in json.loads(capsys.readouterr().out)}
    assert not told["raysect"]["required"] and "pip install raysect" in told["raysect"]["remedy"]
