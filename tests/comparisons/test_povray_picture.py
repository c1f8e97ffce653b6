"""POV-Ray against the exact reference on small pictures; wrong conversions must fail; a bad program is told as such."""

import re
import shutil
import stat

import numpy as np
import pytest

from raytruth.comparisons.renderers import povray, povray_process
from raytruth.comparisons.renderers.povray_process import PovrayError, run
from raytruth.converters.povray import convert
from raytruth.reference_tracer.errors import MissingError
from raytruth.reference_tracer.scene.model import Camera, Light, Material, Object, Rotation, Scene, Tracing
from raytruth.reference_tracer.surfaces import Ellipsoid, Expression, Heart, Paraboloid, Plane, Sphere, Torus
from raytruth.reference_tracer.surfaces.expression import Bounds
from raytruth.reference_tracer.tracer.render import UNDECIDED, render

needs_povray = pytest.mark.skipif(shutil.which("povray") is None, reason="POV-Ray is not installed")


def thing(surface, rotation=None, **material):
    return Object(surface=surface, rotation=rotation, material=Material(**material))


FLOOR = thing(Plane(center=(0.0, -1.0, 0.0), a=0.0, b=1.0, c=0.0), color=(0.8, 0.8, 0.7), reflection=0.2)
DULL = thing(Plane(center=(0.0, -1.0, 0.0), a=0.0, b=1.0, c=0.0), color=(0.8, 0.8, 0.7))
BALL = thing(Sphere(center=(0.0, 0.3, 4.0), r=1.2), color=(0.4, 0.5, 0.9), transparency=0.8, refractive_index=1.3,
             reflection=0.1)
CORE = thing(Sphere(center=(0.2, 0.3, 4.0), r=0.5), color=(0.9, 0.5, 0.4), transparency=0.7, refractive_index=1.0,
             reflection=0.2)
SHADOWLESS = thing(Sphere(center=(-1.5, 0.0, 5.0), r=0.9), color=(0.9, 0.2, 0.2)).model_copy(update={"shadow": False})
TURN = Rotation(axis=(1.0, 0.4, 0.2), degrees=35.0)
CUBE = Bounds(low=(-1.0,) * 3, high=(1.0,) * 3)
INNER = Bounds(low=(-0.8,) * 3, high=(0.8,) * 3)
LOWER = Bounds(low=(-2.0, -2.0, -0.5), high=(2.0, 0.3, 2.0))


def scene(*objects, position=(0.0, 0.0, 0.0), **parts):
    lights = (Light(position=(2.0, 5.0, -1.0), brightness=(0.6, 0.6, 0.5)),
              Light(position=(-3.0, 4.0, 2.0), brightness=(0.3, 0.2, 0.3)))
    return Scene(objects=objects, camera=Camera(position=position, width=120, height=90), **{"lights": lights, **parts})


SCENES = {
    "primitives": scene(FLOOR, thing(Sphere(center=(-1.5, 0.0, 5.0), r=0.9), color=(0.9, 0.2, 0.2), reflection=0.6),
                        thing(Ellipsoid(center=(1.5, 0.2, 5.0), a=1.0, b=0.5, c=0.7), TURN, color=(0.2, 0.9, 0.2)),
                        thing(Torus(center=(0.0, 0.5, 4.0), R=0.7, r=0.2), TURN, color=(0.2, 0.3, 0.9)),
                        thing(Paraboloid(center=(0.0, 2.0, 9.0), a=0.9, b=0.6), TURN, color=(0.9, 0.8, 0.2))),
    "nested glass, one of index 1": scene(FLOOR, BALL, CORE, tracing=Tracing(max_depth=3)),
    "total reflection": scene(FLOOR, thing(Torus(center=(0.0, 0.2, 4.0), R=0.8, r=0.4), TURN, color=(0.5, 0.9, 0.5),
                                           transparency=0.7, refractive_index=1.4, reflection=0.2)),
    "camera within glass": scene(FLOOR, BALL, position=(0.0, 0.3, 3.9)),
    "glass around a hollow": scene(FLOOR, thing(Sphere(center=(0.0, 0.3, 4.0), r=1.0, inside="positive"), transparency=0.7,
                                                refractive_index=1.4, color=(0.5, 0.9, 0.5))),
    "background beyond the last generation": scene(FLOOR, BALL, background=(0.2, 0.3, 0.5), tracing=Tracing(max_depth=2)),
    "rays end": scene(FLOOR, BALL, tracing=Tracing(max_distance=6.0)),
    "no shadows, four samples": scene(DULL, BALL, tracing=Tracing(effects=("reflection", "refraction"), samples=2)),
    "ambient light": scene(FLOOR, BALL, CORE, background=(0.1, 0.1, 0.2), tracing=Tracing(ambient=0.3, max_depth=3)),
    "shadows of what is opaque": scene(FLOOR, BALL, thing(Sphere(center=(-1.5, 0.0, 5.0), r=0.9), color=(0.9, 0.2, 0.2)),
                                       tracing=Tracing(shadows="opaque_only")),
    "objects without shadows": scene(FLOOR, BALL.model_copy(update={"shadow": False}), SHADOWLESS),
    "axes at no right angles": scene(FLOOR, BALL).model_copy(update={"camera": Camera(
        direction=(0.1, -0.1, 1.0), v_x=(1.0, 0.0, 0.0), v_y=(0.1, 1.0, 0.0), width=120, height=90)}),
    "isosurface without a shadow": scene(DULL, thing(Expression(formula="x**4 + y**4 + z**4 - cbrt(0.5)", center=(0.3, 0.0, 4.5),
                                                                bounds=CUBE)).model_copy(update={"shadow": False}),
                                         tracing=Tracing(max_distance=15.0, ambient=0.1)),
    "functions of formulas": scene(DULL, thing(Expression(
        formula="smin(hypot(x, y) - 0.3, hypot(x, y, z) - 0.6, 0.2) + 0.05 sin(5 atan2(y, x)) tanh(z)(cosh(x) - 0.5)"
                " + smoothstep(0, 0.5, y)/20 - mix(0.01, 0.02, x) + asin(z/4)/9 + acos(y/3)/40 + sinh(x)/30",
        center=(0.0, 0.2, 4.0), clip=INNER), TURN, color=(0.4, 0.7, 0.9))),
    "isosurfaces": scene(DULL, thing(Heart(center=(-0.9, 0.2, 4.0)), TURN, color=(0.9, 0.2, 0.3)),
                         thing(Expression(formula="x**4 + y**4 + z**4 - cbrt(0.5)", center=(1.3, 0.0, 4.5), bounds=CUBE), TURN,
                               color=(0.3, 0.8, 0.4)),
                         thing(Expression(formula="y + 1.2 - 0.1*sin(3*x)*cos(2*z)"), color=(0.9, 0.7, 0.3)),
                         tracing=Tracing(max_distance=15.0)),
    # a half-space, a ring, a corner block with a ball taken out of it, and glass: all of them isosurfaces of max(f, ...)
    "isosurfaces of clipped solids": scene(
        DULL, thing(Plane(center=(-1.4, 0.3, 5.0), a=0.3, b=1.0, c=0.2, clip=CUBE), TURN, color=(0.9, 0.2, 0.2)),
        thing(Torus(center=(0.0, 0.5, 4.0), R=0.7, r=0.2, clip=LOWER), TURN, color=(0.2, 0.3, 0.9)),
        thing(Sphere(center=(1.5, 0.2, 5.0), r=0.9, clip=INNER, inside="positive"), TURN, color=(0.2, 0.9, 0.2)),
        thing(Paraboloid(center=(0.0, 2.0, 7.0), a=0.9, b=0.6, clip=CUBE), TURN, color=(0.9, 0.8, 0.2)),
        tracing=Tracing(max_distance=15.0)),
    "isosurface of clipped glass": scene(DULL, thing(Sphere(center=(0.0, 0.2, 4.0), r=1.0, clip=LOWER), TURN,
                                                     transparency=0.7, refractive_index=1.3, reflection=0.1)),
}


def largest(color, of: Scene, exact=None):
    """The largest error of a decided pixel, in units of the brightest possible colour."""
    exact = exact or render(of, "exact")
    error = np.abs(color - exact.color).max(axis=-1)
    return error[exact.status != UNDECIDED].max()


@needs_povray
@pytest.mark.parametrize("name", SCENES)
def test_pov_ray_sees_what_the_reference_sees(name):
    of = SCENES[name]
    exact, picture = render(of, "exact"), povray.render(of)
    limit = 2e-4 if "isosurface" in name else 2e-5
    assert largest(picture.color, of, exact) <= limit
    decided = exact.status != UNDECIDED
    assert np.count_nonzero(~decided) <= (10 if name == "functions of formulas" else 0)
    assert (picture.index == exact.index).all() and (picture.status == exact.status)[decided].all()
    hit = exact.index >= 0
    assert np.all(np.abs(picture.t[hit] - exact.t[hit]) <= (1e-6 if "isosurface" in name else 1e-10) * exact.t[hit])
    # slopes have 16 bits of pi, the chord of half a step is 2.4e-5 an axis
    assert np.linalg.norm(picture.normal - exact.normal, axis=-1)[hit].max() <= 3 * 2.4e-5
    assert picture.metadata["cpu"] >= 0 and picture.metadata["first"] > 0 and picture.metadata["holes"] == ""


@needs_povray
def test_everything_as_isosurface():
    of = scene(DULL, thing(Torus(center=(0.0, 0.2, 4.0), R=0.9, r=0.35), TURN, color=(0.9, 0.2, 0.3)))
    picture = povray.render(of, shapes="isosurface", planes=False)
    assert picture.metadata["isosurfaces"] == 2 and largest(picture.color, of) <= 2e-4
    coarse = povray.render(of, shapes="isosurface", accuracy=1e-3, planes=False)
    assert largest(coarse.color, of) > 1e-3


# --- wrong on purpose ------------------------------------------------------------------------------------------------
def wrong(of: Scene, pattern: str, replacement) -> float:
    """The largest error when `pattern` of the text is replaced."""
    converted = convert(of)
    text, count = re.subn(pattern, replacement, converted.text())
    assert count
    return largest(converted.brightest * run(text, 120, 90).pixels / 65535, of)


@needs_povray
@pytest.mark.parametrize("name, pattern, replacement, error", [
    ("total reflection", r"reflection \{ 0\.06\d* \}", "reflection { 0.2 }", 1e-2),  # R instead of R (1 - T)
    ("total reflection", r"refraction [\d.]+", "refraction 1", 1e-2),  # POV-Ray's own weight of total reflection
    ("camera within glass", r"adc_bailout 0", "", 5e-5),  # POV-Ray's own bailout of 1/255
    ("camera within glass", " inverse", "", 1e-2),  # the twin taken for a second medium
    ("rays end", r"max_trace_level 9", "max_trace_level 2", 1e-3),
    ("nested glass, one of index 1", r"ior 1\.3\d*", "ior 1.5", 1e-2),
    ("ambient light", r"emission 0\.\d*[1-9]\d*", "emission 0", 1e-2),
    ("ambient light", r"diffuse ([\d.]+) emission [\d.]+", r"diffuse \1 emission 0.3", 1e-2),  # the same for any material
    ("objects without shadows", r" no_shadow", "", 1e-2),
    ("axes at no right angles", r"up <[^>]*>", "up <0.0,0.866,0.0>", 1e-2),
    ("primitives", r"torus \{ 0\.7, 0\.2 sturm", "torus { 0.7, 0.2001 sturm", 1e-3),
], ids=lambda v: v if isinstance(v, str) else "")
def test_a_wrong_conversion_is_found(name, pattern, replacement, error):
    assert wrong(SCENES[name], pattern, replacement) > error


@needs_povray
def test_too_small_a_gradient_makes_holes_that_pov_ray_tells(monkeypatch):
    of = scene(thing(Heart(center=(0.0, 0.1, 4.0)), color=(0.9, 0.2, 0.3)))
    small = convert(of).with_gradients({0: 0.3})
    shot = run(small.text(), 120, 90)
    assert largest(small.brightest * shot.pixels / 65535, of) > 0.05
    (line, found), = shot.steep.items()
    assert found > 0.3 and "object 0" in small.text().splitlines()[line - 1]
    # the renderer takes the hint, and tries again
    monkeypatch.setattr(povray, "convert", lambda *_: small)
    picture = povray.render(of, planes=False)
    assert picture.metadata["pictures"] > 1 and picture.metadata["holes"] == ""
    assert largest(picture.color, of) <= 2e-4


@needs_povray
def test_the_essential_line_of_an_error_is_told():
    with pytest.raises(PovrayError, match="exit code 1.*Parse Error.*line|line.*Parse Error"):
        run("sphere { <0,0,0>, }", 8, 8)


# --- bad programs ----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("body, word", [
    ("exit 0", "left no picture"),
    ("echo rubbish > scene.ppm", "no picture of 16 bits"),
    ("printf 'P6\\n2 2\\n65535\\n' > scene.ppm; head -c 24 /dev/zero >> scene.ppm", "2 x 2 instead of 8 x 8"),
    ("printf 'P6\\n8 8\\n65535\\nshort' > scene.ppm", "no picture of 16 bits"),
    ("echo 'Fatal error: out of luck' >&2; exit 3", "exit code 3: Fatal error: out of luck"),
    ("exec sleep 20", "within 0.5 s")])
def test_a_bad_program_is_told_as_such(tmp_path, monkeypatch, body, word):
    program = tmp_path / "povray"
    program.write_text(f"#!/bin/sh\n{body}\n")
    program.chmod(program.stat().st_mode | stat.S_IEXEC)
    monkeypatch.setattr(povray_process.shutil, "which", lambda name: str(program))
    with pytest.raises(PovrayError, match=word):
        run("", 8, 8, seconds=0.5 if "sleep" in body else 20)


def test_a_missing_program_is_one_sentence(monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(MissingError, match="POV-Ray is not installed"):
        run("", 8, 8)
