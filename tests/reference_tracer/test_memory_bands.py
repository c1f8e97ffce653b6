"""Section 6: bands, queues and threads divide the work; none of them may change the picture."""

import numpy as np
import pytest
from closed_forms import Exact
from tracing_support import make_scene, thing

import raytruth.reference_tracer.tracer.render as render_module
from raytruth.reference_tracer.backend import use_threads
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.oracle import literal
from raytruth.reference_tracer.tracer import wavefront
from raytruth.reference_tracer.tracer.render import render

GLASS = {"color": [0.2, 0.3, 0.2], "reflection": 0.3, "transparency": 0.6, "refractive_index": 1.4}
OBJECTS = [thing("sphere", (-0.6, 0, 4), r=1, material=GLASS),
           thing("sphere", (1, -0.2, 5), r=1, material={"reflection": 0.7}),
           thing("plane", (0, -1.2, 0), a=0, b=1, c=0.05, material={"color": [0.6, 0.7, 0.9], "reflection": 0.2})]
LIGHTS = [((3, 4, -1), (0.7, 0.6, 0.5)), ((-3, 2, 3), (0.2, 0.3, 0.4))]
COMMON = {"lights": LIGHTS, "background": (0.1, 0.2, 0.3), "max_depth": 4}
PLANES = ("color", "t", "position", "normal", "index", "depth", "status")


def assert_same(a, b, tolerance=1e-12):
    for name in PLANES:
        np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=0, atol=tolerance, err_msg=name)


def limited(monkeypatch, most: int):
    """Bands and waves of at most `most` rays; returns the list of the waves' lengths to come."""
    lengths = []

    def counting(self, source, *others):
        lengths.append(len(source.wave(self.world, 0)))
        return traced(self, source, *others)

    traced = wavefront.Wavefront._traced
    monkeypatch.setattr(wavefront.Wavefront, "_traced", counting)
    for module in (wavefront, render_module):
        monkeypatch.setattr(module, "MOST_RAYS", most)
    return lengths


@pytest.mark.parametrize("most, samples", [(7, 1), (64, 1), (50, 2), (3, 2), (2, 1)])
def test_bands_and_split_waves_give_the_same_picture(monkeypatch, most, samples):
    """Bands of whole rows, of parts of a row, of one pixel; `most` is smaller than a pixel's samples, too."""
    size = (10, 7) if most > 3 else (4, 3)
    scene = make_scene(*OBJECTS, size=size, samples=samples, **COMMON)
    whole = render(scene)
    lengths = limited(monkeypatch, most)
    divided = render(scene)
    assert_same(whole, divided)
    assert max(lengths) <= max(most, samples**2, 2) and len(lengths) > 6  # undivided: 5 generations


@pytest.mark.parametrize("adaptive", [0, 0.01])
def test_progress_rises_to_one_wave_by_wave(monkeypatch, adaptive):
    """Within a band too: an interrupted look never sees it fall, and the end of each band is where it must be."""
    limited(monkeypatch, 20)
    seen = []
    render(make_scene(*OBJECTS, size=(10, 7), samples=2 if adaptive else 1, adaptive=adaptive, **COMMON),
           progress=seen.append)
    assert seen == sorted(seen) and seen[-1] == 1 and len(seen) > 8
    if not adaptive:
        assert all(min(abs(share - end / 7) for share in seen) < 1e-12 for end in (2, 4, 6))


def test_deep_waves_are_split_so_that_all_generations_fit(monkeypatch):
    """Two mirrors and a ball of glass between them: every generation holds rays that go on. The picture stays."""
    scene = make_scene(*OBJECTS, size=(40, 30), **COMMON | {"max_depth": 12})
    whole = render(scene)
    monkeypatch.setattr(wavefront, "MOST_HELD", 1000 * (92 + 16))  # bytes of a row whose sides fill one word
    monkeypatch.setattr(wavefront, "LEAST_PART", 16)
    held, most = {}, []

    class Counting(wavefront.Wavefront):
        def _traced(self, source, film, generation, primary):
            held[generation] = len(source.wave(self.world, 0))
            most.append(sum(rows for g, rows in held.items() if 0 < g <= generation))
            return super()._traced(source, film, generation, primary)

    monkeypatch.setattr(render_module, "Wavefront", Counting)
    assert_same(whole, render(scene))
    assert max(most) <= 1000 + 16 * 12 and max(held) == 12


def test_threads_do_not_change_the_picture():
    scene = make_scene(*OBJECTS, size=(48, 36), samples=2, **COMMON)
    one, two = render(scene, threads=1), render(scene, threads=2)
    assert one.metadata["threads"] == 1 and two.metadata["threads"] == 2
    assert_same(one, two)


@pytest.mark.parametrize("count", [0, -1, 5000])
def test_a_senseless_number_of_threads_is_refused(count):
    with pytest.raises(InputError, match="threads"):
        use_threads(count)


def test_rays_are_counted():
    """One pixel, a mirror that sees the background: one camera ray and one reflection. Queues are padded to two."""
    scene = make_scene(thing("plane", (0, 0, 2), a=0, b=0, c=-1, material={"reflection": 1}), size=(4, 3))
    assert render(scene).metadata["rays"] == 24


@pytest.mark.parametrize("method", ["paper", "exact"])
def test_M3_sides_of_more_objects_than_a_word_holds(method):
    """130 balls of glass fill three words of sides. Against the oracle, whose sides are a table of truth values."""
    random = np.random.default_rng(3)
    material = {"color": [0.5, 0.4, 0.3], "transparency": 0.8, "refractive_index": 1.1}
    centers = [(x, y, random.uniform(4, 9)) for x in np.linspace(-4, 4, 13) for y in np.linspace(-3, 3, 10)]
    centers.sort(key=lambda center: -np.hypot(center[0], center[1]))  # the last ones stand in the middle of the picture
    balls = [thing("sphere", center, r=random.uniform(0.3, 0.5), material=material) for center in centers]
    scene = make_scene(*balls, lights=LIGHTS[:1], size=(8, 6), camera={"fov": 75}, max_depth=1, max_distance=12,
                       step_size=0.5)
    expected = literal.render(scene, Exact(scene) if method == "exact" else None)
    found = render(scene, method)
    assert {0, 1, 2} == set(found.index[found.index >= 0] // 63)
    np.testing.assert_allclose(found.color, expected, rtol=0, atol=1e-12)


def test_M3_the_last_bit_of_a_word_and_the_first_of_the_next():
    """Objects 62, 63 and 126 are glass balls (n = 1, T = 1/2, black) in a row on the axis; the rest stand out of sight.
    The white background comes through six crossings: 1/64."""
    glass = {"color": [0, 0, 0], "transparency": 0.5, "refractive_index": 1}
    balls = [thing("sphere", (100 + 3 * k, 0, 0), r=1) for k in range(128)]
    for z, k in ((3, 62), (6, 63), (9, 126)):
        balls[k] = thing("sphere", (0, 0, z), r=1, material=glass)
    picture = render(make_scene(*balls, background=(1, 1, 1)))
    assert picture.index.tolist() == [[62]] and picture.color[0, 0] == pytest.approx([1 / 64] * 3, rel=1e-15)
