"""Every file that is written, opened by the program it is for: what that finds is what our own converter gives."""

import os
import re
import shutil
import subprocess
import sys
from decimal import Decimal
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import OpenImageIO as oiio
import pytest
import trimesh

from raytruth.comparisons.bench import port
from raytruth.comparisons.renderers import povray
from raytruth.comparisons.verdicts.metrics import interior
from raytruth.converters.export import ENDINGS, chosen, export, mesh
from raytruth.converters.mesh.files import SUFFIXES, rounded_up
from raytruth.converters.mitsuba import convert
from raytruth.converters.mitsuba.files import AOVS
from raytruth.converters.mitsuba.variant import mi
from raytruth.converters.plain import plain
from raytruth.reference_tracer.errors import InputError, MissingError, UnsupportedError
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.model import Camera, Light, Material, Object, Rotation, Scene, Tracing
from raytruth.reference_tracer.surfaces import Bounds, Expression, Heart, Paraboloid, Plane, Sphere, Torus
from raytruth.reference_tracer.tracer.render import render

CELLS = 48
BALL, RING = Sphere(center=(-1.2, 0.1, 4.0), r=0.8), Torus(center=(1.0, 0.2, 4.5), R=0.8, r=0.3)
TURN = Rotation(axis=(1.0, 0.0, 0.0), degrees=90.0)  # the ring's axis z goes to -y
FLOOR = Plane(center=(0.0, -1.0, 0.0), a=0.0, b=1.0, c=0.0)
MITSUBA = Path(sys.executable).with_name("mitsuba")
MITSUBA_BAR, POVRAY_BAR = 1e-6, 2e-5
needs_povray = pytest.mark.skipif(shutil.which("povray") is None, reason="POV-Ray is not installed")


def scene(*objects, **parts):
    lights = (Light(position=(2.0, 5.0, -1.0), brightness=(0.6, 0.6, 0.5)), Light(position=(-3.0, 4.0, 2.0), brightness=(0.3,) * 3))
    return Scene(**{"name": "exported", "objects": objects, "camera": Camera(width=64, height=48), "lights": lights, **parts})


def thing(surface, rotation=None, name="", **material):
    return Object(surface=surface, rotation=rotation, name=name, material=Material(**material))


SCENE = scene(thing(FLOOR, name="floor", color=(0.8, 0.8, 0.7)), thing(BALL, name="ball", color=(0.9, 0.3, 0.2), reflection=0.4),
              thing(RING, TURN, "ring", color=(0.2, 0.5, 0.9)))


def off(k, points):
    """The distance (n,) of points from object k of SCENE, by closed forms, and the unit normals (n, 3) there."""
    if k == 0:
        return np.abs(points[:, 1] + 1), np.broadcast_to([0.0, 1.0, 0.0], points.shape)
    away = points - np.array((BALL if k == 1 else RING).center)
    if k == 2:
        in_plane = away * [1, 0, 1]
        away = away - RING.R * in_plane / np.linalg.norm(in_plane, axis=1, keepdims=True)
    length = np.linalg.norm(away, axis=1)
    return np.abs(length - (BALL.r if k == 1 else RING.r)), away / length[:, None]


def parts_of(shape) -> dict[str, trimesh.Trimesh]:
    return dict(shape.geometry) if isinstance(shape, trimesh.Scene) else {"": shape}


# --- meshes, by trimesh ----------------------------------------------------------------------------------------------
@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("k, name", list(enumerate(["floor", "ball", "ring"])))
def test_a_mesh_keeps_the_error_that_its_file_states(tmp_path, suffix, k, name):
    file = tmp_path / f"one{suffix}"
    told, = export(SCENE, file, name, CELLS).told
    words = re.search(r"within ([\d.e-]+) of the surface", told)
    stated = float(words[1])
    opened, = parts_of(trimesh.load(file)).values()
    assert opened.is_watertight == (name != "floor") and opened.is_winding_consistent
    corners, middles = (off(k, np.asarray(points))[0] for points in (opened.vertices, opened.triangles_center))
    assert corners.max() <= (1e-15 * 60 if suffix == ".obj" else 2**-24 * 60) and middles.max() <= stated
    if name != "floor":
        assert middles.max() > stated / 4  # no bound that anything keeps
        assert off(k, np.asarray(opened.triangles_center) * 1.003)[0].max() > stated
        assert opened.volume > 0
    if suffix != ".stl":
        assert np.einsum("ij,ij->i", opened.vertex_normals, off(k, np.asarray(opened.vertices))[1]).min() > 1 - 1e-6
    if suffix == ".glb":
        assert 0.95 * stated <= opened.metadata["error_bound"] <= stated
    else:
        head = file.read_bytes()[:{".stl": 80, ".ply": 500, ".obj": 300}[suffix]]
        assert words[0].encode() in head


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_all_objects_go_into_one_file(tmp_path, suffix):
    export(SCENE, tmp_path / f"all{suffix}", cells=CELLS)
    opened = trimesh.load(tmp_path / f"all{suffix}", **{"split_objects": True} if suffix == ".obj" else {})
    alone = [mesh(SCENE, k, CELLS) for k in range(3)]
    assert opened.area == pytest.approx(sum(part.area for part in alone), rel=1e-5)
    names = set(parts_of(opened))
    if suffix in (".obj", ".glb"):
        assert len(names) == 3
        assert sum(shape.is_watertight for shape in parts_of(opened).values()) == 2
    assert suffix != ".glb" or names == {"0-floor", "1-ball", "2-ring"}
    assert suffix != ".obj" or re.findall("^o (.*)$", (tmp_path / "all.obj").read_text(), re.M) == ["0-floor", "1-ball", "2-ring"]


def test_rounding_never_states_less():
    assert [rounded_up(x) for x in (0.0014499, 1.0001e-5, 0.0, 99.1)] == ["0.0015", "1.1e-05", "0", "100"]
    for x in np.exp(np.random.default_rng(7).uniform(-30, 9, 2000)).tolist():
        assert Decimal(x) <= Decimal(rounded_up(x)) <= Decimal(x) * Decimal("1.1001")


@pytest.mark.parametrize("surface, watertight, told", [
    (Paraboloid(center=(0.0, 2.0, 9.0), a=0.9, b=0.6), False, "beyond all a ray can reach"),
    (Paraboloid(center=(0.0, 0.0, 4.0), a=1.0, b=1.0, clip=Bounds(low=(-2.0, -2.0, 0.0), high=(2.0, 2.0, 1.5))), True, ""),
    (Heart(center=(0.0, 0.0, 5.0)), True, ""),
    (Expression(formula="x*y*z - 1"), False, "holds all a ray can reach"),
    (Expression(formula="x**4 + y**4 + z**4 - 1", center=(0.0, 0.0, 4.0), bounds=Bounds(low=(-1.0,) * 3, high=(1.0,) * 3)), True, "")])
def test_surfaces_without_an_end_are_cut_and_the_rest_is_watertight(tmp_path, surface, watertight, told):
    done = export(scene(thing(surface)), tmp_path / "one.ply", cells=CELLS)
    assert told in done.told[0] and ("cut" in done.told[0]) == bool(told)
    assert trimesh.load(tmp_path / "one.ply").is_watertight == watertight


def test_an_object_is_chosen_by_name_or_number():
    twins = scene(thing(BALL, name="twin"), thing(RING, name="twin"), thing(FLOOR, name="7"), thing(FLOOR, name="0"))
    assert (chosen(twins, "7"), chosen(twins, 1), chosen(twins, "0"), chosen(twins, None)) == ([2], [1], [3], [0, 1, 2, 3])
    for wanted, sentence in (("twin", "2 objects are called 'twin'; give the number of one: 0, 1"), ("4", "from 0 to 3"),
                             ("-1", "from 0 to 3"), ("", "no object ''"), ("²", "or a name: 'twin'"), ("9" * 5000, "from 0 to 3")):
        with pytest.raises(InputError, match=re.escape(sentence)) as told:
            chosen(twins, wanted)
        assert len(str(told.value)) < 300


# --- Mitsuba, by its own command -------------------------------------------------------------------------------------
def by_mitsuba(file: Path, variant="llvm_ad_rgb") -> dict[str, np.ndarray]:
    """The layers of the picture that Mitsuba's command makes of a scene file."""
    done = subprocess.run([MITSUBA, "-m", variant, "-o", file.with_suffix(".exr"), file], capture_output=True, text=True,
                          cwd=file.parent.parent, env=dict(os.environ), timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    image = oiio.ImageBuf(str(file.with_suffix(".exr")))
    channels = dict(zip(image.spec().channelnames, np.moveaxis(image.get_pixels(oiio.FLOAT), -1, 0)))
    layer = lambda *names: np.stack([channels[name] for name in names], axis=-1).astype(float)
    return {"color": layer("R", "G", "B"), "t": layer("t.T")[..., 0], "P": layer("P.X", "P.Y", "P.Z"),
            "N": layer("N.X", "N.Y", "N.Z"), "shape": layer("shape.I")[..., 0]}


def in_memory(of: Scene) -> dict[str, np.ndarray]:
    converted = convert(of, "native", CELLS)
    seen = np.array(mi.render(converted.scene, sensor=converted.sensor, spp=1, integrator=mi.load_dict({"type": "aov", "aovs": AOVS})))
    return {"t": seen[..., 0], "P": seen[..., 1:4], "N": seen[..., 4:7], "shape": seen[..., 7]}


def apart(a, b) -> float:
    return max(float(np.abs(a[name] - b[name]).max()) for name in ("t", "P", "N"))


@pytest.mark.parametrize("of", [
    SCENE, scene(thing(Heart(center=(0.0, 0.0, 4.0)), TURN, color=(0.9, 0.1, 0.2)), thing(Sphere(r=9.0, inside="positive")),
                 background=(0.1, 0.2, 0.3), camera=Camera(position=(0.3, 0.4, -1.0), direction=(0.1, 0.0, 1.0), width=48, height=64)),
    scene(thing(BALL, transparency=0.8, refractive_index=1.3, reflection=0.1), thing(FLOOR, reflection=1.0), thing(RING, transparency=1.0))],
    ids=["primitives", "within a room", "glass"])
def test_mitsuba_renders_the_file_as_what_is_converted_in_memory(tmp_path, of):
    (tmp_path / "folder").mkdir()
    export(of, tmp_path / "folder/scene.xml", cells=CELLS)  # the command runs elsewhere: names are relative to the file
    found, ours, exact = by_mitsuba(tmp_path / "folder/scene.xml"), in_memory(of), render(of)
    assert apart(found, ours) <= MITSUBA_BAR
    scalar = by_mitsuba(tmp_path / "folder/scene.xml", "scalar_rgb")  # a tracer of its own, not Embree: edges may differ
    assert np.quantile(np.abs(scalar["t"] - ours["t"]), 0.99) < 1e-4
    inner = interior({**vars(exact), "camera": np.array(of.camera.position)}) & (found["t"] < of.tracing.max_distance)
    pairs = set(zip(found["shape"][inner].tolist(), exact.index[inner].tolist()))  # Mitsuba numbers shapes in its own order
    assert len(pairs) == len({shape for shape, _ in pairs}) == len({index for _, index in pairs}) >= 2
    met = inner & (exact.index >= 0)
    assert np.abs(found["t"] - exact.t)[met].max() < 2e-2  # meshes of few cells
    assert np.isfinite(found["color"]).all() and found["color"].max() > 0.1


def test_a_wrong_scene_file_is_noticed(tmp_path):
    export(SCENE, tmp_path / "scene.xml", cells=CELLS)
    text = (tmp_path / "scene.xml").read_text()
    for right, wrong in (('value="0.8"', 'value="0.80001"'), ('value="60.0"', 'value="60.001"'),
                         ('<string name="filename" value="scene-object-2.ply" />', '<string name="filename" value="scene-object-2.ply" /><boolean name="face_normals" value="true" />')):
        assert text.count(right) == 1
        (tmp_path / "scene.xml").write_text(text.replace(right, wrong))
        assert apart(by_mitsuba(tmp_path / "scene.xml"), in_memory(SCENE)) > MITSUBA_BAR


def test_stock_light_is_as_bright_as_the_models_at_its_distance(tmp_path):
    """A white floor 3 below a lamp that hangs over the only bounded object's centre: illumination 0.5 there, by both."""
    speck = thing(Sphere(center=(0.0, -1.0, 4.0), r=0.01))
    of = scene(thing(FLOOR), speck, lights=(Light(position=(0.0, 2.0, 4.0), brightness=(0.5,) * 3),), tracing=Tracing(max_depth=0),
               camera=Camera(direction=(0.02, -1.0, 4.0), width=1, height=1))
    export(of, tmp_path / "scene.xml", cells=CELLS)
    assert by_mitsuba(tmp_path / "scene.xml")["color"][0, 0] == pytest.approx(render(of).color[0, 0], rel=5e-3)


# --- POV-Ray and ports -----------------------------------------------------------------------------------------------
def by_povray(file: Path) -> np.ndarray:
    """The picture that POV-Ray makes of a file by the command that stands in it, in units of the brightest colour."""
    command = re.search(r"^// (povray .*)$", file.read_text(), re.M)[1].split()
    done = subprocess.run(command, cwd=file.parent, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    return oiio.ImageBuf(str(file.with_suffix(".png"))).get_pixels(oiio.UINT16)[..., :3] / 65535


@needs_povray
@pytest.mark.parametrize("of", [SCENE, scene(*SCENE.objects, thing(Heart(center=(0.0, 1.2, 5.0)), color=(0.9, 0.1, 0.2))),
                                scene(thing(FLOOR, color=(0.5,) * 3), thing(BALL), background=(0.1, 0.2, 1.7))],
                         ids=["primitives", "an isosurface", "a bright sky"])
def test_povray_renders_the_file_as_what_is_converted_in_memory(tmp_path, of):
    told = export(of, tmp_path / "scene.pov").told
    ours = povray.render(of, planes=False)
    brightest = ours.metadata["brightest"]
    found = brightest * by_povray(tmp_path / "scene.pov")
    assert np.abs(found - ours.color).max() <= POVRAY_BAR * brightest
    assert (brightest == 1) != any(f"divided by {brightest!r}" in line for line in told)
    assert np.quantile(np.abs(found - render(of).color), 0.97) <= 2e-4
    text = (tmp_path / "scene.pov").read_text()
    (tmp_path / "scene.pov").write_text(text.replace("direction <0.0,0.0,1.0>", "direction <0.0,0.0,1.001>"))
    assert np.abs(brightest * by_povray(tmp_path / "scene.pov") - ours.color).max() > POVRAY_BAR * brightest


@needs_povray
def test_what_a_povray_file_does_not_show_is_told(tmp_path):
    """Two mirrors under a sky: paths end at generation 2, in black there and in the sky here."""
    of = scene(thing(FLOOR, reflection=0.7), thing(BALL, reflection=0.7), background=(0.4, 0.5, 0.6), tracing=Tracing(max_depth=2, samples=2))
    told = " ".join(export(of, tmp_path / "scene.pov").told)
    assert "rays beyond generation 2 end black" in told and "mean of 2 x 2" in told
    ours = povray.render(of, planes=False)
    found = ours.metadata["brightest"] * by_povray(tmp_path / "scene.pov")
    assert found.shape[:2] == (96, 128)
    found = found.reshape(48, 2, 64, 2, 3).mean(axis=(1, 3))
    unlike = np.abs(ours.color - found).max(axis=-1)
    assert unlike.max() > 0.05 and (unlike <= POVRAY_BAR).mean() > 0.1  # the sky itself, and what no long path ends on


def test_a_port_reads_the_plain_text(tmp_path):
    of = library.scene("figure-07-torus").resized(40, 30)
    export(of, tmp_path / "scene.txt")
    assert (tmp_path / "scene.txt").read_text() == plain(of)
    try:
        program = port.build()
    except MissingError as error:
        pytest.skip(str(error))
    subprocess.run([program, tmp_path / "scene.txt", tmp_path / "raw", "2"], check=True, capture_output=True, timeout=100)
    colors = np.frombuffer((tmp_path / "raw").read_bytes(), float, 3 * 40 * 30).reshape(30, 40, 3)
    assert np.quantile(np.abs(colors - render(of, "paper").color), 0.99) <= 1e-9


# --- untrusted scenes, and places ------------------------------------------------------------------------------------
HOSTILE = ["../../escape", "a/b", "x\n// object 7\n#include \"/etc/passwd\"", "--><evil/><!--", "..", "\x1b[31m", "名", "C:\\x", "--"]


@pytest.mark.parametrize("name", HOSTILE)
def test_names_of_objects_make_no_files_and_end_no_comments(tmp_path, name):
    of = scene(thing(RING, name=name), thing(Expression(formula="x**4+y**4+z**4-1", center=(0.0, 0.0, 9.0), bounds=Bounds(low=(-1.5,) * 3, high=(1.5,) * 3)), name=name))
    (tmp_path / "in").mkdir()
    for suffix in ENDINGS[:-1]:
        export(of, tmp_path / f"in/scene{suffix}", cells=8)
    assert {p.relative_to(tmp_path).as_posix() for p in tmp_path.rglob("*")} == {
        "in", *(f"in/scene{suffix}" for suffix in ENDINGS[:-1]), "in/scene-object-0.ply", "in/scene-object-1.ply"}
    root = ElementTree.fromstring((tmp_path / "in/scene.xml").read_bytes())
    assert {child.tag for child in root} == {"default", "boolean", "integrator", "sensor", "emitter", "shape"}
    for suffix in (".ply", ".obj", ".glb", ".stl"):
        assert trimesh.load(tmp_path / f"in/scene{suffix}").area > 1
    words = (tmp_path / "in/scene.pov").read_text("ascii").split("#version")[0]
    assert all(line.startswith("//") for line in words.splitlines())


def test_a_failed_export_leaves_what_was_there(tmp_path):
    (tmp_path / "scene.xml").write_text("before")
    (tmp_path / "scene-object-2.ply").mkdir()  # in the place of the ring's mesh
    with pytest.raises(InputError, match="scene-object-2.ply: cannot be written; choose another file"):
        export(SCENE, tmp_path / "scene.xml", cells=8)
    assert (tmp_path / "scene.xml").read_text() == "before" and len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("suffix, object_, error, sentence", [
    (".usd", None, InputError, "the output must end in one of .ply, .obj, .stl, .glb, .xml, .pov, .txt"),
    ("", None, InputError, "the output must end in one of"), (".xml", "ball", InputError, "holds a whole scene; one object goes to .ply"),
    (".ply", "cube", InputError, "exported: has no object 'cube'; give a number from 0 to 2, or a name: 'floor', 'ball', 'ring'")])
def test_what_cannot_be_written_is_one_sentence(tmp_path, suffix, object_, error, sentence):
    with pytest.raises(error, match=re.escape(sentence)):
        export(SCENE, tmp_path / f"scene{suffix}", object_, CELLS)
    assert not list(tmp_path.iterdir())


def test_what_a_format_cannot_express_is_refused(tmp_path):
    with pytest.raises(UnsupportedError, match="no surface of type expression"):
        export(scene(thing(Expression(formula="x+y"))), tmp_path / "scene.txt")
    with pytest.raises(InputError, match="no ray can reach what is to be written"):
        export(scene(thing(FLOOR), thing(Plane(center=(0.0, -999.0, 0.0), a=0.0, b=1.0, c=0.0))), tmp_path / "scene.ply", 1)
