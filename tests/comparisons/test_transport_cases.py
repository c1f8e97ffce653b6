"""Mitsuba's own light transport: every case holds, and a wrong variant of each is found."""

from dataclasses import replace

import numpy as np
import pytest

from raytruth.comparisons.transport import cases
from raytruth.comparisons.transport.cases import CORNER_LIGHT, NOISY, ball, glow, scene
from raytruth.comparisons.transport.measure import measure
from raytruth.converters.mitsuba.dressed import diffuse, document, dressed, mirror, sun
from raytruth.converters.mitsuba.plugins import DocumentMaterial
from raytruth.converters.mitsuba.radiance import radiance
from raytruth.converters.mitsuba.variant import dr, mi
from raytruth.reference_tracer.scene.model import Camera

SIZE, FEW = (128, 96), (16, 64, 256)


def small(id, **changes):
    """The case `id` at a size and with a number of samples that a test can wait for."""
    case, = cases.find([id])
    size = (64, 48) if case.ladder else SIZE
    ladder = FEW if case.ladder else ()
    return replace(case, **{"scene": case.scene.resized(*size), "ladder": ladder, **changes})


def broken(measured):
    return {gate.name for gate in measured.gates if not gate.holds}


@pytest.mark.parametrize("id", [case.id for case in cases.CASES])
def test_every_case_holds(id):
    assert broken(measure(small(id))) == set()


def test_the_cases_cover_every_effect_and_measure_what_physics_does_otherwise():
    every = cases.CASES
    assert len({case.id for case in every}) == len(every)
    effects = {case.effect for case in every if not case.is_finding}
    assert effects == {"shading", "shadow", "reflection", "refraction", "total reflection", "mixing", "multisampling"}
    assert {case.id for case in every if case.is_finding} == {"one-over-pi", "fall-off", "interreflection", "fresnel"}


# --- wrong on purpose ------------------------------------------------------------------------------------------------
def turned_sun(scene, samples, seed):
    """The sun a hundredth off its place."""
    light = scene.lights[0]
    x, y, z = light.position
    moved = scene.model_copy(update={"lights": (light.model_copy(update={"position": (x + 1e4, y, z)}),)})
    return cases.lit_by_sun(moved, samples, seed)


class OneCrossing(DocumentMaterial):
    """Light loses T for a whole solid in its way, not for each of its two surfaces."""

    def eval_null_transmission(self, si, active=True):
        return mi.Color3f(dr.sqrt(self.transparency)) & active


mi.register_bsdf("one_crossing", OneCrossing)


def light_in_shadow(kind):
    def rendered(scene, samples, seed):
        dress = lambda o: {"bsdf": {**document(o.material), "type": kind}}
        made = dressed(scene, dress, {"sun": sun(scene.lights[0])})
        return radiance(made, {"type": "volpath", "max_depth": 9, "rr_depth": 999}, scene.camera, samples, seed)
    return rendered


def denser_glass(scene, samples, seed):
    thicker = tuple(o.model_copy(update={"material": o.material.model_copy(update={"refractive_index": 1.41})})
                    if o.material.transparency else o for o in scene.objects)
    return cases.ratio(scene.model_copy(update={"objects": thicker}), samples, seed)


def lossy(scene, samples, seed):
    return cases.in_glass(scene, samples, seed, reflected=0.999)


def three_by_three(scene, samples, seed):
    return cases.filmed(scene.traced_with(samples=3), samples, seed)


WRONG = {
    "a light 1 % brighter": ("diffuse", lambda *a: cases.lit_by_sun(*a, strength=1.01)),
    "a light elsewhere": ("hard-shadow", turned_sun),
    "T instead of T^2": ("clear-shadow", light_in_shadow("one_crossing")),
    "opacity T": ("clear-shadow", lambda *a: cases.veiled(*a, opacity=lambda transparency: transparency)),
    "a path too short": ("mirror", lambda *a: cases.mirrored(*a, depth=2)),
    "bodies that light each other": ("mirrors", lambda *a: cases.mirrored_in_company(
        *a, plain=lambda o: diffuse(o.material.color))),
    "no (1 - R)": ("mirror-blend", lambda *a: cases.glowing_mirrors(*a, glow=lambda o: glow(
        o.model_copy(update={"material": o.material.model_copy(update={"reflection": 0.0})})))),
    "Fresnel's factors left in": ("refraction", cases.raw),
    "another refractive index": ("refraction", denser_glass),
    "Fresnel's factors left in a bubble": ("refraction-thin", cases.raw),
    "total reflection that loses 0.1 %": ("total-reflection-inside", lossy),
    "the same from outside": ("total-reflection-outside", lossy),
    "the whole model 1 % brighter": ("everything", lambda *a: cases.everything(*a, brighter=1.01)),
    "shadow rays that stop at glass": ("everything", lambda *a: cases.everything(*a, integrator="path")),
    "other samples": ("multisampling", three_by_three),
    "irradiance by the document's brightness": ("fall-off", lambda *a: cases.lit_by_sun(*a)),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_variant_fails(name):
    id, wrong = WRONG[name]
    found = broken(measure(small(id, mitsuba=wrong)))
    assert found & {"color p99", "failing pixels", "largest z"}


def test_the_own_material_attenuates_shadows_like_the_mask():
    """The control of "T instead of T^2": what fails there is the exponent and nothing else. It makes no choices."""
    case = small("clear-shadow", scene=cases.CLEAR.resized(*SIZE), ladder=())
    right, wrong = (measure(replace(case, mitsuba=light_in_shadow(kind))) for kind in ("document", "one_crossing"))
    assert right.metrics["color mean"] < 2e-4 and "failing pixels" not in broken(right)
    assert wrong.metrics["color mean"] > 2e-3 and "failing pixels" in broken(wrong)


@pytest.mark.parametrize("id, wrong", [
    ("fall-off", lambda p: p.color * (cases.LAMP_DISTANCE / np.linalg.norm(
        np.array(p.scene.lights[0].position) - p.position, axis=-1))[..., None]),  # fades with r
    ("one-over-pi", lambda p: p.color),
    ("interreflection", lambda p: p.color * (1 + np.array(p.scene.objects[0].material.color))),  # one bounce
    ("fresnel", lambda p: p.color)])
def test_a_wrong_prediction_of_physics_fails(id, wrong):
    assert broken(measure(small(id, predicted=wrong))) & {"color p99", "largest z"}


HALF = scene("half-mirror",
             [ball((0.0, 0.3, 0.0), 1.0, reflection=0.3), ball((0.0, -7.2, 0.5), 6.5, (0.85, 0.7, 0.45))],
             [CORNER_LIGHT], Camera(position=(0.0, 1.5, -5.0), direction=(0.0, -0.25, 1.0), fov=55.0, **NOISY))


def blended(scene, samples, seed):
    """A half mirror by the stock plugin that blends two materials."""
    def dress(obj):
        r = obj.material.reflection
        local = document(obj.material.model_copy(update={"reflection": 0.0}))
        return {"bsdf": {"type": "blendbsdf", "weight": r, "local": local, "mirror": mirror()} if r else local}

    made = dressed(scene, dress, {"sun": sun(scene.lights[0])})
    return radiance(made, {"type": "path", "max_depth": 3, "rr_depth": 999}, scene.camera, samples, seed)


def own_mirror(scene, samples, seed):
    made = dressed(scene, lambda o: {"bsdf": document(o.material)}, {"sun": sun(scene.lights[0])})
    return radiance(made, {"type": "path", "max_depth": 3, "rr_depth": 999}, scene.camera, samples, seed)


def test_a_biased_blend_of_delta_lobes_is_found():
    """Mitsuba 3.9.1 mirrors with less than the weight it was given; more samples do not help."""
    case = small("everything", scene=HALF.resized(64, 48), mitsuba=blended)
    assert "slope" in broken(measure(case))
    assert broken(measure(replace(case, mitsuba=own_mirror, ladder=()))) == set()


def test_pixels_that_theory_says_nothing_of_do_not_make_a_case_hold():
    nothing = small("diffuse", where=lambda picture: np.zeros(picture.t.shape, bool))
    assert "pixels compared" in broken(measure(nothing))


def test_a_picture_that_is_not_finite_fails():
    def poisoned(scene, samples, seed):
        seen = cases.lit_by_sun(scene, samples, seed)
        seen.mean[10, 10] = np.nan
        return seen

    assert "not finite" in broken(measure(small("diffuse", mitsuba=poisoned)))


def test_fresnels_equations():
    """Normal incidence: ((n - 1) / (n + 1))^2; beyond the critical angle: all; Brewster's angle: half of s alone."""
    assert cases.fresnel(np.array(1.0), 1.5) == pytest.approx(0.04)
    assert cases.fresnel(np.array(0.3), 0.8) == pytest.approx(1.0)  # sine 0.954 > 0.8
    brewster = np.cos(np.arctan(1.5))
    s = (np.cos(np.arctan(1.5)) - 1.5 * np.cos(np.pi / 2 - np.arctan(1.5))) ** 2 / (
        np.cos(np.arctan(1.5)) + 1.5 * np.cos(np.pi / 2 - np.arctan(1.5))) ** 2
    assert cases.fresnel(np.array(brewster), 1.5) == pytest.approx(s / 2)
