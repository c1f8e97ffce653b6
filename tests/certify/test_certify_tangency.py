"""Proofs where they are hardest: rays within a few units in the last place of touching, decided exactly."""

import numpy as np
import pytest
from certify_support import make_scene, thing
from flint import ctx

from raytruth.reference_tracer.backend import backend
from raytruth.reference_tracer.certify.objects import Radius, local_rays, ray_of
from raytruth.reference_tracer.certify.records import numpy, row_type
from raytruth.reference_tracer.certify.verdict import decide
from raytruth.reference_tracer.tracer.world import World

TURNED = {"axis": [1, 2, -0.5], "degrees": 33}
THINGS = {
    "sphere": thing("sphere", (0.3, -0.2, 0.1), r=1.3),
    "ellipsoid": thing("ellipsoid", (0.1, 0.2, -0.3), a=0.5, b=1.7, c=1.25, rotation=TURNED),
    "torus": thing("torus", (0.1, 0, 0.2), R=1.1, r=0.6, rotation=TURNED),
    "heart": thing("heart", (0.05, -0.1, 0.02), rotation=TURNED),
    "formula": thing("expression", formula="exp(x**2 + y**2 + 0.5 * z**2) + 0.1 * sin(3 * z) - 2.5",
                     bounds={"low": [-1, -1, -1.5], "high": [1, 1, 1.5]})}
LADDER = np.concatenate([np.arange(-20, 21), [-1e3, 1e3, -1e5, 1e5, -1e7, 1e7]])  # steps of one unit in the last place


def _rows(offsets, o, across, d):
    """Rays from o + offset across along d, all of them outside at their start."""
    rows = np.zeros(len(offsets), row_type(1))
    rows["o"], rows["d"], rows["limit"] = o + np.outer(offsets, across), d, 20
    return rows


def _rays_about_a_tangent(scene, proofs, seed):
    """Rays shifted sideways until they touch: the shift is bisected, each ray decided exactly, down to the last bit."""
    random = np.random.default_rng(seed)
    d = random.normal(size=3)
    d /= np.linalg.norm(d)
    across = np.cross(d, random.normal(size=3))
    across /= np.linalg.norm(across)
    o = np.array(scene.objects[0].surface.center) - 6 * d

    def hits(offset) -> bool:
        rows = _rows([offset, offset], o, across, d)
        return bool(decide(scene, rows[0], local_rays(proofs, rows)[:, 0]).hits)

    tried = np.linspace(0, 4, 41)
    last = max(k for k, offset in enumerate(tried) if hits(offset))
    low, high = tried[last], tried[last + 1]
    while high - low > np.spacing(low):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if hits(middle) else (low, middle)
    return _rows(low + np.spacing(1.0) * LADDER, o, across, d)


def _contradictions(scene, method) -> tuple[int, int]:
    """(contradictions of what the method's answers and enclosures claim, rays it decides)."""
    world = World(scene, method, backend())
    proofs = World(scene, "proof", backend())
    wrong = decided = 0
    with ctx.workprec(192):
        for seed in range(3):
            rows = _rays_about_a_tangent(scene, proofs, seed)
            ray, count = ray_of(world, rows), len(rows)
            hit, local = world.nearest(ray), local_rays(proofs, rows)
            radius = numpy(Radius(proofs).of(ray, hit), count)
            met, t, undecided = (numpy(a, count) for a in (hit.index == 0, hit.t, hit.undecided))
            for k in np.flatnonzero(~undecided):
                verdict = decide(scene, rows[k], local[:, k])
                decided += 1
                wrong += bool(verdict.hits) != bool(met[k])
                wrong += bool(verdict.hits and met[k] and verdict.error({"index": 0, "t": t[k]}) > radius[k])
    return wrong, decided


@pytest.mark.parametrize("name", THINGS)
def test_no_proof_about_a_nearly_touching_ray_is_wrong(name):
    wrong, decided = _contradictions(make_scene(THINGS[name], max_distance=20), "proof")
    assert wrong == 0 and decided > 12  # those far from touching at least


def test_arithmetic_that_rounds_to_nearest_is_no_proof():
    """The same rays and the same algorithm without outward rounding: exact decisions catch it."""
    assert _contradictions(make_scene(THINGS["heart"], max_distance=20), "interval")[0] > 0
