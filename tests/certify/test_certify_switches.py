"""Certificates of pictures with switches F1 to F5: they hold, 77 digits included, and a tracer without the switch is found."""

import dataclasses

import numpy as np
import pytest
from certify_support import make_scene, mirror_and_glass, thing
from flint import arb, ctx

from raytruth.reference_tracer.certify import certify
from raytruth.reference_tracer.certify.precise import PreciseTracer
from raytruth.reference_tracer.tracer import world as worlds
from raytruth.reference_tracer.tracer.families import Family
from raytruth.reference_tracer.tracer.optics import Optics
from raytruth.reference_tracer.tracer.world import World

TWO = (((2, 3, -2), 0.8), ((-2, 2, 0), 0.7))
OBLIQUE = {"v_x": (1.0, 0.0, 0.0), "v_y": (0.15, 1.0, 0.0), "direction": (0.1, -0.1, 1.0)}


def switched(name):
    changes = {"F1": {"lights": "balanced"}, "F2": {"ambient": 0.2}, "F3": {"shadows": "opaque_only"},
               "F4": {"range": "path", "max_distance": 7.0}, "F5": {}}
    scene = mirror_and_glass(max_depth=3).traced_with(**changes[name])
    lamps = scene.model_validate(make_scene(thing("sphere", r=1), lights=TWO).model_dump(by_alias=True)).lights
    camera = scene.camera.model_copy(update=OBLIQUE if name == "F5" else {})
    return scene.model_copy(update={"lights": lamps, "camera": camera})


@pytest.mark.parametrize("name", ["F1", "F2", "F3", "F4", "F5"])
def test_a_picture_with_a_switch_holds(name):
    certificate = certify(switched(name), sample=120, paths=10)
    assert certificate.passed and not certificate.findings and certificate.undecided_rays == 0
    assert certificate.paths.paths == 10 and certificate.paths.deepest >= 2 and certificate.paths.largest_error < 1e-12
    assert min(certificate.audit.by_kind.values()) > 5 and len(certificate.audit.by_kind) == 4


class Adds(Optics):
    def combined(self, illumination, light, balanced):
        return illumination + light


def _without(name, monkeypatch):
    """A tracer that does not know the switch."""
    if name == "F1":
        monkeypatch.setattr(World, "optics", Adds())
    if name == "F2":
        monkeypatch.setattr(World, "ambient", property(lambda self: 0.0, lambda self, value: None), raising=False)
    if name == "F3":
        made = Family.__init__
        monkeypatch.setattr(Family, "__init__", lambda self, *rest: made(self, *rest[:-1], True))
        monkeypatch.setattr(World, "dims", property(lambda self: True, lambda self, value: None), raising=False)
    if name == "F4":
        monkeypatch.setattr(World, "range_of", lambda self, ray: self.max_distance)
    if name == "F5":
        right = worlds.frame
        monkeypatch.setattr(worlds, "frame", lambda camera: dataclasses.replace(
            right(camera), v_y=np.cross(right(camera).v_dir, right(camera).v_x)))


@pytest.mark.parametrize("name", ["F1", "F2", "F3", "F4", "F5"])
def test_a_tracer_without_the_switch_does_not(name, monkeypatch):
    scene = switched(name)
    _without(name, monkeypatch)
    certificate = certify(scene, sample=120, paths=10)
    assert not certificate.passed
    if name in ("F1", "F2", "F5"):  # no ray is wrong: the colours are, which only the 77-digit paths know
        assert certificate.paths.above_bar + len(certificate.paths.wrong) > 0 and not certificate.findings
    else:
        assert {finding.rays for finding in certificate.findings} <= {"shadow", "reflection", "refraction"}


def test_seventy_seven_digits_of_every_switch():
    """A wall at 4, seen straight on: a lamp of 3/4 at the camera, one of 1/2 beside it at cos 4/5, ambient 1/4; then the same
    behind clear glass, whose shadow is not dark, on a path that ends before or behind the wall."""
    lamps = (((0, 0, 0), 0.75), ((3, 0, 0), 0.5))
    wall = thing("plane", (0, 0, 4), {}, a=0, b=0, c=-1)

    def shows(scene, expected):
        with ctx.workprec(300):
            return abs(PreciseTracer(scene).pixel(1, 1).color[0] - arb(expected)) < arb(10)**-60

    plain = make_scene(wall, lights=lamps, size=(3, 3))
    for changes, expected in (({}, "1.15"), ({"lights": "balanced"}, "0.85"), ({"ambient": 0.25}, "1.4"),
                              ({"lights": "balanced", "ambient": 0.25}, "0.8875")):
        assert shows(plain.traced_with(**changes), expected)
    glass = thing("sphere", (0, 0, 2), {"transparency": 1, "color": (0, 0, 0), "refractive_index": 1.0}, r=0.5)
    for max_distance, expected in ((4.1, "1.15"), (3.9, "0")):
        scene = make_scene(glass, wall, lights=lamps, size=(3, 3), range="path", shadows="opaque_only",
                           max_distance=max_distance)
        assert shows(scene, expected)
