"""The C++ port and `paper` share nothing but the document: where they agree, both follow it."""

import subprocess

import numpy as np
import pytest

from raytruth.comparisons.bench import port
from raytruth.converters.plain import plain
from raytruth.reference_tracer.errors import MissingError, UnsupportedError
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.model import Light
from raytruth.reference_tracer.tracer.render import render
from raytruth.reference_tracer.tracer.sensitivity import sensitivity

AGREE = 1e-9
MOST_EXCUSED = 0.002  # of the pixels; measured: 2 of 4800 of the heart, none elsewhere
SIZES = {"figure-02-16-samples": (40, 30), "figure-03-256-samples": (20, 15)}


@pytest.fixture(scope="module", autouse=True)
def program():
    try:
        port.build()
    except MissingError as error:
        pytest.skip(str(error))


def small(name):
    return library.scene(name).resized(*SIZES.get(name, (80, 60)))


def differing(scene, ours, theirs):
    """Pixels that differ, and how many of them rounding excuses."""
    apart = np.abs(np.where(ours.t == theirs.t, 0, np.nan_to_num(ours.t - theirs.t, posinf=1e9, neginf=1e9)))
    off = ~(np.abs(theirs.color - ours.color).max(axis=-1) <= AGREE) | (theirs.index != ours.index) | (apart > AGREE)
    if not off.any():
        return 0, 0
    # where no light falls the colour says nothing of a root: a light at the camera, without shadows, shows what it sees
    lit = scene.traced_with(effects=("reflection", "refraction")).model_copy(
        update={"lights": (*scene.lights, Light(position=scene.camera.position))})
    excused = sensitivity(scene, "paper", precision=64).excuses(theirs.color)
    return int(off.sum()), int(np.sum(off & excused & (sensitivity(lit, "paper", precision=64).bound > AGREE)))


@pytest.mark.filterwarnings("ignore:invalid value encountered in subtract")  # infinity - infinity where both miss
@pytest.mark.parametrize("name", library.names())
def test_the_port_agrees_with_paper(name):
    scene = small(name)
    off, excused = differing(scene, render(scene, "paper"), port.render(scene))
    assert off == excused
    assert excused <= MOST_EXCUSED * scene.camera.width * scene.camera.height


def _oblique(scene):
    camera = scene.camera.model_copy(update={"v_x": (1.0, 0.1, 0.0), "v_y": (0.0, 1.0, 0.1)})
    return scene.model_copy(update={"camera": camera})


def _shadowless(scene):
    return scene.model_copy(update={"objects": tuple(o.model_copy(update={"shadow": k % 2 == 0})
                                                     for k, o in enumerate(scene.objects))})


SWITCHES = {"F1": lambda scene: scene.traced_with(lights="balanced"), "F2": lambda scene: scene.traced_with(ambient=0.1),
            "F1 and F2": lambda scene: scene.traced_with(lights="balanced", ambient=0.1),
            "F3": lambda scene: scene.traced_with(shadows="opaque_only"),
            "F4": lambda scene: scene.traced_with(range="path", max_distance=25.0), "F5": _oblique, "shadow": _shadowless}


@pytest.mark.filterwarnings("ignore:invalid value encountered in subtract")
@pytest.mark.parametrize("name", SWITCHES)
def test_the_port_follows_every_switch(name):
    scene = small("figure-17-scene1")
    switched = SWITCHES[name](scene)
    ours, theirs = render(switched, "paper"), port.render(switched)
    off, excused = differing(switched, ours, theirs)
    assert off == excused and excused <= MOST_EXCUSED * 4800
    assert np.sum(np.abs(theirs.color - port.render(scene).color).max(axis=-1) > 0.01) > 100


def test_a_scene_without_switches_is_written_as_ever():
    text = plain(library.scene("figure-17-scene1"))
    assert not {"axes", "figures", "shadowless"} & {line.split()[0] for line in text.splitlines()}


@pytest.mark.parametrize("line, word", [("figures some 0 attenuate ray", "unknown word some"), ("figures sum 0", "incomplete"),
                                        ("axes 1 0 0 0 1", "incomplete")])
def test_the_port_refuses_words_it_does_not_know(tmp_path, line, word):
    file = tmp_path / "scene.txt"
    file.write_text(plain(small("figure-05-sphere")) + line + "\n")
    done = subprocess.run([port.build(), file, tmp_path / "out"], capture_output=True, text=True)
    assert done.returncode == 1 and word in done.stderr and not (tmp_path / "out").exists()


@pytest.mark.filterwarnings("ignore:invalid value encountered in subtract")
@pytest.mark.parametrize("name, changes", [
    ("figure-17-scene1", {"max_depth": 2}), ("figure-17-scene1", {"step_size": 0.25}),
    ("figure-07-torus", {"tolerance": 1e-3}), ("figure-05-sphere", {"max_distance": 2.5})])
def test_a_port_that_does_otherwise_is_told_apart(name, changes):
    scene = small(name)
    off, excused = differing(scene, render(scene, "paper"), port.render(scene.traced_with(**changes)))
    assert off - excused >= 10


def test_threads_change_nothing():
    scene = small("figure-18-scene2")
    one, three = port.render(scene, threads=1), port.render(scene, threads=3)
    assert np.array_equal(one.color, three.color) and np.array_equal(one.t, three.t)


def test_a_plain_scene_refuses_what_it_cannot_say():
    scene = library.scene("figure-05-sphere")
    with pytest.raises(UnsupportedError, match="tracing.cutoff"):
        plain(scene.traced_with(cutoff=0.1))
    with pytest.raises(UnsupportedError, match="tracing.effects"):
        plain(scene.traced_with(effects=("shadow",)))


def test_numbers_are_written_so_that_they_are_read_back_exactly():
    scene = library.scene("figure-17-scene1")
    words = [line.split() for line in plain(scene).splitlines()]
    colors = [tuple(map(float, line[1:4])) for line in words if line[0] == "object"]
    assert colors == [obj.material.color for obj in scene.objects]
