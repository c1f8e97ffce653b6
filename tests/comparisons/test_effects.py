"""What doing otherwise than a decision changes: every switch of the figures has a scene on which it shows."""

import numpy as np
import pytest

from raytruth.comparisons.effects import ALTERNATIVES, requests
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.model import Camera, Tracing
from raytruth.reference_tracer.tracer.render import render

SWITCHES = {"F1": "lights", "F2": "ambient", "F3": "shadows", "F4": "range"}
OF_FIGURES = [a for a in ALTERNATIVES if a.decision.startswith("F")]


def test_every_switch_of_the_figures_is_shown_and_by_itself():
    assert {a.decision for a in OF_FIGURES} == {*SWITCHES, "F5"}
    for alternative in OF_FIGURES:
        text = library.scene(alternative.scene)
        other = alternative.of(text)
        changed = {name for name in Tracing.model_fields if getattr(other.tracing, name) != getattr(text.tracing, name)}
        moved = {name for name in Camera.model_fields if getattr(other.camera, name) != getattr(text.camera, name)}
        expected = (set(), {"v_x", "v_y"}) if alternative.decision == "F5" else ({SWITCHES[alternative.decision]}, set())
        assert (changed, moved) == expected
        # as the text has it, one at a time
        assert getattr(text.tracing, SWITCHES.get(alternative.decision, "range")) == getattr(
            Tracing(), SWITCHES.get(alternative.decision, "range"))


@pytest.mark.parametrize("alternative", OF_FIGURES, ids=lambda a: f"{a.decision}--{a.scene}")
def test_it_shows(alternative):
    scene = library.scene(alternative.scene).resized(64, 48)
    first, second = (render(s, alternative.method).color for s in (scene, alternative.of(scene)))
    assert np.mean(np.abs(first - second).max(axis=-1) > 1 / 255) > 0.01


def test_a_scene_without_effects_asks_for_nothing():
    scene = library.scene("figure-17-scene1")
    assert requests([scene.model_copy(update={"name": "mine"})]) == []
    assert len(requests([scene])) == 2 * sum(a.scene == scene.name for a in ALTERNATIVES)
