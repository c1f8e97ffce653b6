"""certify: sound pictures hold, and each deliberate fault is found and named."""

import json

import numpy as np
import pytest
from certify_support import ClaimsTooMuch, IsOff, SkipsRoots, TakesSideFromSign, breaking, make_scene, mirror_and_glass, thing

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.certify import certify
from raytruth.reference_tracer.certify.text import told
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.surfaces.outside import Outside
from raytruth.reference_tracer.tracer import rays, shading, wavefront
from raytruth.reference_tracer.tracer.camera_rays import camera_wave
from raytruth.reference_tracer.tracer.film import HIT
from raytruth.reference_tracer.tracer.render import render
from raytruth.reference_tracer.tracer.world import World


@pytest.fixture(scope="module")
def sound():
    return certify(mirror_and_glass(), sample=300, paths=12)


def _faults(certificate) -> set[tuple[str, str, str]]:
    return {(f.fault, f.rays, f.object.partition(" (")[0]) for f in certificate.findings}


def test_a_sound_picture_holds(sound):
    assert sound.passed and not sound.findings
    assert sum(k.wrong for k in sound.kinds.values()) == 0 and sound.undecided_rays == 0
    assert 0 < sound.largest_gap < 1e-13 and 0 < sound.largest_radius < 1e-11
    assert sound.audit.contradictions == sound.audit.wrong == 0 and sound.audit.rays == 300
    assert sound.audit.at_edges == 150 and min(sound.audit.by_kind.values()) >= 10 and len(sound.audit.by_kind) == 4
    assert 0 < sound.audit.largest_share < 1


def test_every_ray_of_the_picture_is_counted(sound):
    """The fast tracer's own counters: camera rays are pixels; secondary rays; shadow rays asked for."""
    scene = mirror_and_glass()
    world = World(scene, "exact", backend())
    count, seen = scene.camera.width * scene.camera.height, {"secondary": 0, "shadow": 0}

    def observe(wave, interaction):
        active = np.broadcast_to(wave.weight.numpy() > 0, len(wave))
        seen["secondary"] += int(active.sum()) if wave.generation else 0
        seen["shadow"] += int(np.broadcast_to(interaction.lights_asked.numpy(), len(wave))[active].sum())

    wavefront.trace(world, camera_wave(world, world.camera_sides(), 0, count, 1), count, observe=observe)
    kinds = sound.kinds
    assert kinds["primary"].rays == count
    assert kinds["reflection"].rays + kinds["refraction"].rays == seen["secondary"] > count
    assert kinds["shadow"].rays == seen["shadow"]
    for k in kinds.values():
        assert k.hits + k.misses + k.undecided + k.settled == k.rays


def test_the_picture_equals_its_77_digit_recomputation(sound):
    """The bar is 1e-10; fp64 and well-conditioned paths give 1e-14."""
    assert sound.paths.paths == 12 and sound.paths.deepest == 4 and sound.paths.rays > 50
    assert sound.paths.largest_error < 1e-12 and not sound.paths.above_bar and not sound.paths.wrong


@pytest.mark.parametrize("method", ["interval", "descartes"])
def test_other_methods_that_miss_nothing_hold_too(method):
    assert certify(mirror_and_glass(max_depth=2), method, sample=100, paths=2).passed


def test_the_literal_method_fails_where_steps_miss(monkeypatch):
    """A wire thinner than half a step of 0.2 is stepped over: missed hits, on the wire and nowhere else."""
    scene = make_scene(thing("torus", (0, 0, 3), {}, "wire", R=1, r=0.03),
                       thing("plane", (0, 0, 5), {}, "wall", a=0, b=0, c=-1), size=(48, 36), step_size=0.2, lights=())
    certificate = certify(scene, "paper", sample=100, paths=0)
    assert not certificate.passed and ("wrong object", "primary", "wire") in _faults(certificate)
    assert {k[2] for k in _faults(certificate)} == {"wire"}


def test_lost_roots_are_found_and_named(monkeypatch):
    breaking(monkeypatch, "broken", SkipsRoots)
    certificate = certify(mirror_and_glass(), "broken", sample=300, paths=4)
    faults = _faults(certificate)
    assert not certificate.passed
    assert ("missed hit", "primary", "floor") in faults and ("wrong object", "primary", "glass ball") in faults
    assert any(kind == "refraction" for _, kind, _ in faults) and any(kind == "reflection" for _, kind, _ in faults)
    # one in 50 of the hits
    primary = certificate.kinds["primary"]
    assert 0.005 < primary.wrong / primary.hits < 0.06


def test_sides_taken_from_the_sign_at_the_origin_are_found_and_named(monkeypatch):
    """Camera rays are unharmed; of the others about half start on a wrong side and meet the object they leave."""
    breaking(monkeypatch, "broken", TakesSideFromSign)
    certificate = certify(mirror_and_glass(max_depth=2), "broken", sample=300, paths=8)
    faults = _faults(certificate)
    assert not certificate.passed and certificate.kinds["primary"].wrong == 0
    assert ("wrong shadow", "shadow", "floor") in faults or ("wrong shadow", "shadow", "mirror ball") in faults
    assert {("wrong object", "reflection"), ("false hit", "reflection")} & {f[:2] for f in faults}
    assert certificate.kinds["refraction"].wrong > 0.1 * certificate.kinds["refraction"].rays
    assert certificate.audit.wrong > 0 and certificate.audit.contradictions == 0


def test_a_tracer_that_forgets_to_flip_sides_is_found(monkeypatch):
    """The method is sound and gets wrong sides: rays in glass that claim to be outside, and paths that go astray."""
    monkeypatch.setattr(rays.Sides, "flipped", lambda self, index: self)
    certificate = certify(mirror_and_glass(max_depth=2), sample=300, paths=8)
    assert ("wrong side", "refraction", "glass ball") in _faults(certificate)
    assert ("wrong side", "refraction", "glass ring") in _faults(certificate)
    assert certificate.paths.wrong


def test_distances_beyond_their_enclosure_are_found(monkeypatch):
    breaking(monkeypatch, "broken", IsOff)
    certificate = certify(mirror_and_glass(max_depth=0), "broken", sample=50, paths=4)
    faults = {f[:2] for f in _faults(certificate)}
    assert {("wrong distance", "primary"), ("wrong by exact decision", "primary")} <= faults
    # shadow rays start a millionth inside: off the surface, on the wrong side of it
    assert faults & {("wrong side", "shadow"), ("wrong by exact decision", "shadow")}
    assert certificate.kinds["primary"].wrong == certificate.kinds["primary"].hits
    assert certificate.largest_gap == pytest.approx(1e-6, rel=1e-6)


def test_a_proof_that_claims_too_much_is_contradicted(monkeypatch):
    breaking(monkeypatch, "proof", ClaimsTooMuch, instead_of="proof")
    certificate = certify(mirror_and_glass(max_depth=0), sample=200, paths=0)
    assert certificate.audit.contradictions > 10 and not certificate.passed
    assert any(fault == "proof contradicted" for fault, _, _ in _faults(certificate))


def test_a_box_that_cuts_its_surface_is_found(monkeypatch):
    """The proofs believe a formula's box, which is checked when a scene is read; python-flint does not look at it."""
    box = {"low": [-0.5, -1.1, -1.1], "high": [0.5, 1.1, 1.1]}
    monkeypatch.setattr("raytruth.reference_tracer.surfaces.expression.outside", lambda *_, **__: Outside(1))
    scene = make_scene(thing("expression", (0, 0, 3), {}, "cut ball", formula="x**2 + y**2 + z**2 - 1", bounds=box))
    certificate = certify(scene, sample=400, paths=0)
    assert ("proof contradicted", "primary", "cut ball") in _faults(certificate)


def test_coinciding_surfaces_are_undecided_and_say_so():
    """Two equal balls in one place: no arithmetic tells which is hit, and a picture that decides it does not hold (M4)."""
    ball = lambda name, c: thing("sphere", (0, 0, 3), {"color": c}, name, r=1)
    scene = make_scene(ball("red", (1, 0, 0)), ball("blue", (0, 0, 1)), lights=())
    certificate = certify(scene, sample=50, paths=4)
    primary = certificate.kinds["primary"]
    assert primary.undecided > 30 and primary.undecided + primary.misses == primary.rays
    assert {f.fault for f in certificate.undecided} == {"two surfaces at one distance"}
    decided = (render(scene, "exact").status == HIT).any()
    assert certificate.passed == (not decided)
    assert {f.fault for f in certificate.findings} == ({"decided at a tie"} if decided else set())


def test_a_touching_ray_is_settled_by_exact_arithmetic():
    """The ball of radius 3 about (0, 3, 3) touches the camera's axis, which is the central ray of an odd picture."""
    scene = make_scene(thing("sphere", (0, 3, 3), {}, "ball", r=3), size=(9, 9), fov=20, lights=())
    certificate = certify(scene, sample=81, paths=0)
    assert certificate.audit.touching == 1  # its neighbours pass below or cross
    assert certificate.passed and certificate.undecided_rays <= 1


def test_a_certificate_is_told_in_text_and_as_json(sound):
    text = told(sound)
    assert "holds" in text.splitlines()[0] and "refraction" in text and "77 digits" in text
    document = json.loads(json.dumps(sound.document()))
    assert document["passed"] is True and document["kinds"]["primary"]["rays"] == 432
    assert document["audit"]["rays"] == 300 and document["versions"]["python-flint"]


def test_progress_rises_to_the_end():
    seen = []
    certify(make_scene(thing("sphere", (0, 0, 3), r=1), size=(8, 6)), sample=5, paths=1,
            progress=lambda stage, share: seen.append((stage, share)))
    assert [s for _, s in seen] == sorted(s for _, s in seen) and seen[-1][1] == pytest.approx(1)


def test_nonsense_is_refused():
    scene = make_scene(thing("sphere", (0, 0, 3), r=1), size=(8, 6))
    with pytest.raises(InputError, match="unknown method"):
        certify(scene, "guess")
    with pytest.raises(InputError, match="must not be negative"):
        certify(scene, sample=-1)


def test_shadow_rays_that_run_astray_are_found(monkeypatch):
    """The tracer's own shadow rays are compared with those that its interactions call for; here they point backwards."""
    monkeypatch.setattr(shading, "Ray", lambda o, d, sides: rays.Ray(o, -d, sides))
    certificate = certify(mirror_and_glass(max_depth=1), sample=50, paths=8)
    assert "shadow rays astray" in {fault for fault, _, _ in _faults(certificate)}
    assert certificate.paths.wrong or certificate.paths.above_bar
