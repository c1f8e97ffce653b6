"""Attribution: every fault is taken for what it is, by a renderer that shares no tracing with the reference, and the
right tracer for nothing."""

from dataclasses import replace

import numpy as np
import pytest

from raytruth.comparisons.attribution import cases, derived
from raytruth.comparisons.attribution.bounds import SINGLE, accuracy_of, bounds
from raytruth.comparisons.attribution.document import STAGES
from raytruth.comparisons.attribution.measure import attribute, of_fault, of_renderer
from raytruth.comparisons.attribution.stages import Pictures
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.tracer.render import render

ISSUE = {"y-flipped": "camera", "normal-not-turned": "normal", "shadow-once": "shadow", "as-printed": "refraction",
         "no-1-minus-r": "mixing"}


def effect(name: str, width: int = 80, height: int = 60):
    return library.scene(f"effect-{name}").resized(width, height)


def right(scene):
    return render(scene, "exact")


@pytest.mark.parametrize("id", ISSUE)
def test_a_fault_is_named_by_mitsuba_alone(id):
    fault = cases.fault(id)
    scene = effect("mixing") if id == "y-flipped" else library.scene(fault.effect).resized(80, 60)  # shows there too
    found = attribute(scene, of_renderer("mitsuba-native"), of_fault(id))
    assert found.stage == ISSUE[id] == fault.stage
    before, after = np.split(np.array(STAGES), [STAGES.index(found.stage)])
    outcome = {e.stage: e.outcome for e in found.evidence}
    assert all(outcome[stage] != "diverges" for stage in before)
    assert outcome[after[0]] == "diverges" and all(outcome[stage] == "not asked" for stage in after[1:])


def test_the_right_tracer_is_taken_for_nothing_by_mitsuba():
    found = attribute(effect("mixing"), of_renderer("mitsuba-native"), of_renderer("exact"))
    assert found.stage is None and not found.pixels
    assert {e.outcome for e in found.evidence} == {"agrees", "not asked"}  # sampling: one sample a pixel


SLOW = "no-total-reflection"  # many rays bounce; attribution.json has it


@pytest.mark.parametrize("id", [id for id in cases.FAULTS if id not in ISSUE and id != SLOW])
def test_every_other_fault_is_named_by_the_reference(id):
    fault = cases.fault(id)
    scene = library.scene(fault.effect).resized(64, 48)
    assert attribute(scene, of_fault(""), of_fault(id)).stage == fault.stage


def test_a_fault_stays_in_its_own_tracer():
    scene = effect("mixing", 24, 18)
    before = right(scene).index
    assert np.array_equal(of_fault("y-flipped")(scene).index[::-1], before)
    assert np.array_equal(right(scene).index, before) and not np.array_equal(before[::-1], before)


def test_an_unknown_fault_is_one_sentence():
    with pytest.raises(InputError, match="unknown fault 'gremlins'"):
        cases.fault("gremlins")


# --- pictures that tell no more than colour, object and distance, as an external renderer's ---------------------------
def without(picture, *names):
    return replace(picture, **{name: np.full_like(getattr(picture, name), np.nan) for name in names})


def test_a_normal_is_told_by_its_cosine_where_no_normals_are_told():
    fault = cases.fault("normal-not-turned")
    scene = library.scene(fault.effect).resized(64, 48)
    blind = lambda s: without(right(s), "normal", "position")
    assert attribute(scene, blind, of_fault(fault.id)).stage == "normal"


@pytest.mark.parametrize("turned, words", [
    (lambda plane: plane[::-1], "upside down"), (lambda plane: plane[:, ::-1], "mirrored"),
    (lambda plane: np.roll(plane, 1, axis=0), "a pixel too low"),
    (lambda plane: np.roll(plane, -1, axis=1), "a pixel too far left")])
def test_a_turned_picture_is_the_camera_s_fault_though_no_position_is_told(turned, words):
    def faulty(scene):
        picture = right(scene)
        planes = {name: turned(getattr(picture, name)) for name in ("color", "t", "index", "normal", "status")}
        return without(replace(picture, **planes), "position")

    found = attribute(effect("mixing"), right, faulty)
    assert found.stage == "camera" and words in found.sentence


def test_a_field_of_view_over_the_shorter_side_is_the_camera_s_fault():
    def faulty(scene):
        half = np.tan(np.radians(scene.camera.fov / 2)) * scene.camera.width / scene.camera.height
        camera = scene.camera.model_copy(update={"fov": float(2 * np.degrees(np.arctan(half)))})
        return without(right(scene.model_copy(update={"camera": camera})), "position")

    found = attribute(effect("mixing"), right, faulty)
    assert found.stage == "camera" and "over the shorter side" in found.sentence


@pytest.mark.parametrize("change, stage", [
    (lambda p: p.index.__setitem__((slice(20, 24), slice(16, 20)), 3), "hit"),
    (lambda p: p.t.__imul__(1 + 1e-4), "root"),
    (lambda p: p.normal.__imul__(1 + 1e-3), "normal"),
    (lambda p: p.color.__imul__(1.01), "shading"),
    (lambda p: p.color.__setitem__((slice(None, None, 5), slice(None, None, 5)), 0), "shadow")])
def test_each_plane_names_its_stage(change, stage):
    def faulty(scene):
        picture = right(scene)
        change(picture)
        return picture

    assert attribute(effect("mixing"), right, faulty).stage == stage


def test_rounding_never_counts():
    def single(scene):
        return render(scene, "exact", precision=32)

    assert attribute(effect("refraction"), right, single).stage is None


def test_bounds_are_small_where_nothing_is_near_and_large_at_edges():
    scene = derived.local(effect("mixing"))
    bound = bounds(scene, SINGLE)
    assert np.median(bound.color) < 1e-4 < bound.color.max()
    index = right(scene).index
    assert bound.allows(index).all() and not bound.allows(index + 7).any()


# --- derived scenes ---------------------------------------------------------------------------------------------------
def test_derived_scenes_leave_later_stages_nothing_to_do():
    scene = effect("mixing", 60, 45)
    white = right(derived.geometry(scene))
    rays = derived.pixel_directions(scene)
    cosine = np.where(white.index >= 0, -np.sum(rays * white.normal, axis=-1), 0)
    assert np.allclose(white.color, cosine[..., None], atol=1e-12, equal_nan=True)  # cos(phi1), and no shadow
    assert white.depth.max() == 0
    m = scene.objects[3].material  # the weights are those of section 4.3.4
    here = white.index == 3
    shown = right(derived.weights(scene)).color[here]
    expected = cosine[here][:, None] * np.array(m.color) * (1 - m.reflection) * (1 - m.transparency)
    assert np.allclose(shown, expected, atol=1e-12)


def test_an_object_is_looked_at_from_within():
    scene = effect("total-reflection", 60, 45)
    picture = right(derived.geometry(scene))
    from raytruth.reference_tracer.scene.placement import is_inside

    for k in (1, 2):  # a ball holds its own centre, a ring does not
        inner = derived.within(scene, k, {"index": picture.index, "t": picture.t})
        assert is_inside(scene.objects[k], inner.camera.position)
        assert (right(inner).index == 0).all()


# --- histories --------------------------------------------------------------------------------------------------------
def test_histories_add_up_to_the_pixel_on_both_sides():
    scene = effect("mixing", 60, 45)
    ours, theirs = of_renderer("exact"), of_renderer("mitsuba-native")
    picture = ours(scene)
    deepest = np.unravel_index(np.argmax(np.where(picture.index == 3, picture.depth, 0)), picture.depth.shape)
    for one in (ours, theirs):
        history, = one.rays(scene, [tuple(map(int, deepest))])
        total = sum(ray.weight * np.array(ray.color) for ray in history.rays)
        assert np.allclose(total, picture.color[deepest], atol=1e-5)
        assert history.rays[0].kind == "camera" and history.rays[0].object == "both"
        assert {r.kind for r in history.rays if r.generation == 1} == {"reflection", "refraction"}
    a, b = (one.rays(scene, [tuple(map(int, deepest))])[0] for one in (ours, theirs))
    assert [(r.generation, r.kind, r.object, r.lights) for r in a.rays] == [
        (r.generation, r.kind, r.object, r.lights) for r in b.rays]


def test_pictures_are_made_once():
    made = []
    pictures = Pictures(lambda s: made.append(s.hash) or right(s), right)
    scene = effect("mixing", 24, 18)
    assert pictures.pair(scene) is pictures.pair(scene) and len(made) == 1


def test_a_mesh_whose_error_is_not_measurable_is_held_to_nothing():
    picture = right(effect("mixing", 24, 18))
    measured = replace(picture, metadata={"renderer": "embree", "scene": "mixing", "measured_mesh_error": 1e-3})
    assert accuracy_of([picture, measured]).unit > SINGLE.unit
    with pytest.raises(InputError, match="embree.*not measurable"):
        accuracy_of([picture, replace(measured, metadata={**measured.metadata, "measured_mesh_error": None})])
