"""Solids whose f has multiple roots on its whole surface, held against the plain ball that they are."""

import numpy as np
import pytest
from certify_support import TrustsItsSide, breaking, make_scene, thing
from flint import ctx

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.certify import certify
from raytruth.reference_tracer.certify.census import Census
from raytruth.reference_tracer.certify.objects import crossings_of, local_rays
from raytruth.reference_tracer.certify.records import SHADOW, row_type, settled_within
from raytruth.reference_tracer.certify.run import take
from raytruth.reference_tracer.certify.verdict import decide
from raytruth.reference_tracer.tracer.world import World

BALL = "(x**2 + y**2/4 + z**2 - 1)"
FORMS = {"fifth power": f"{BALL}**5", "product": f"{BALL}*{BALL}*{BALL}", "no polynomial": f"(exp{BALL} - 1)**3",
         "kink": f"{BALL}*abs{BALL}"}
EVERYTHING = 10**6  # rays


def _scene(formula):
    bounds = {"low": [-1.1, -2.1, -1.1], "high": [1.1, 2.1, 1.1]}
    glass = {"reflection": 0.3, "transparency": 0.4, "refractive_index": 1.3}
    return make_scene(thing("expression", (0.1, 0.05, 4), glass, "solid", formula=formula, bounds=bounds),
                      thing("plane", (0, -1.5, 0), {"reflection": 0.2}, "floor", a=0, b=1, c=0),
                      size=(16, 12), max_depth=2)


def _rays(scene, method):
    """All rays of the picture with the answers of `method` and of the proofs, and each in every object's own frame."""
    world, proofs = (World(scene, m, backend()) for m in (method, "proof"))
    count = scene.camera.width * scene.camera.height
    census = Census(world, proofs, np.zeros(count, bool), EVERYTHING, np.zeros(count, bool))
    take(census, lambda share: None)
    rows = census.sample.draw(EVERYTHING)
    return rows, local_rays(proofs, rows)


@pytest.mark.parametrize("form", FORMS)
def test_what_is_decided_about_a_multiple_root_is_what_the_ball_does(form, as_written):
    """Each ray's truth is the ball's, decided exactly; a decided answer must be it, position included."""
    ball, decided = _scene(BALL), {"audited": 0, "proven": 0}
    rows, local = _rays(_scene(FORMS[form]), "exact")
    with ctx.workprec(192):
        for k, row in enumerate(rows):
            verdict = decide(ball, row, local[:, k])
            if verdict.undecided or verdict.wrong_side >= 0:  # such a ray has lost its way before
                continue
            for name in decided:
                if not row[name]["undecided"]:
                    assert verdict.agrees(row[name], settled_within(row.reshape(1))[0]), (name, row, str(verdict))
                    decided[name] += 1
    assert min(decided.values()) > 300 and len(rows) > 600


@pytest.mark.parametrize("form", ["fifth power", "product"])
def test_no_sample_size_contradicts_another(form):
    scene = _scene(FORMS[form])
    for sample in (0, 100, 1000, 5000):
        certificate = certify(scene, sample=sample, paths=4)
        assert certificate.passed and certificate.audit.contradictions == certificate.audit.wrong == 0
        assert certificate.audit.rays == min(sample, certificate.rays)


def _leaving_from_the_wrong_side(scene, depth):
    """Rays known to be outside of the ball that start `depth` inside it and head out, at all angles to its surface."""
    random = np.random.default_rng(5)
    n, across = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in random.normal(size=(2, 200, 3)))
    across -= n * (n * across).sum(axis=1, keepdims=True)
    d = n + across * random.uniform(0, 3, (200, 1))
    rows = np.zeros(200, row_type(1))
    rows["o"] = np.array(scene.objects[0].surface.center) + (1 - depth) * n
    rows["d"], rows["limit"], rows["kind"] = d / np.linalg.norm(d, axis=1, keepdims=True), 20, SHADOW
    return rows


def _decided_wrong(scene, method, depth) -> int:
    """Leaving its surface a ray crosses nothing, whatever side of it rounding has put the origin on (M3)."""
    count, undecided = crossings_of(World(scene, method, backend()), _leaving_from_the_wrong_side(scene, depth))
    return int(((count[0] > 0) & ~undecided[0]).sum())


@pytest.mark.parametrize("formula", ["{}", "({})**3", "({})**5", "(exp{} - 1)**3", "{}*abs{}", "cbrt{}"])
def test_a_method_that_trusts_the_side_it_is_given_is_found(formula, monkeypatch, as_written):
    ball = "(x**2 + y**2 + z**2 - 1)"
    scene = make_scene(thing("expression", (0.1, 0.05, 4), formula=formula.format(ball, ball),
                             bounds={"low": [-1.1] * 3, "high": [1.1] * 3}))
    breaking(monkeypatch, "broken", TrustsItsSide, instead_of="interval")
    for depth in (1e-12, 1e-8, 1e-4):
        assert not any(_decided_wrong(scene, method, depth) for method in ("exact", "interval", "proof"))
    # a simple root hides the fault: its slope is certain across it; elsewhere the rest of the way back counts as a crossing
    assert (_decided_wrong(scene, "broken", 1e-4) > 0) == (formula != "{}")
