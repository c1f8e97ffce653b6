"""Followed pixels: their rays' shares add up to the colour that the picture has there."""

import numpy as np
import pytest

from raytruth.comparisons import renderers
from raytruth.comparisons.attribution import followed
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.tracer.image_files import save_npz

PLACES = [[10, 20, 0.1], [12, 16, 0.2], [17, 9, float("nan")]]


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    """What a worker is asked of both methods on a scene whose rays bounce, and what they rendered."""
    scene, folder = library.scene("effect-total-reflection").resized(32, 24, samples=1), tmp_path_factory.mktemp("planes")
    pictures = {name: renderers.render(name, scene) for name in ("exact", "paper")}
    for name, picture in pictures.items():
        save_npz(picture, folder / f"{name}.npz")
    return {"scene": scene.model_dump_json(by_alias=True), "renderers": list(pictures), "places": PLACES,
            "thorough": True, "results": str(folder),
            "planes": [str(folder / f"{name}.npz") for name in pictures]}, list(pictures.values())


def total(history) -> np.ndarray:
    return sum(ray.weight * np.array(ray.color) for ray in history.rays)


def test_the_rays_of_a_pixel_add_up_to_its_colour(asked):
    request, pictures = asked
    found = followed.Followed.model_validate(followed.answer(request))
    assert [(p.row, p.col) for p in found.pixels] == [(row, col) for row, col, _ in PLACES]
    for pixel in found.pixels:
        for history, color, picture in zip((pixel.a, pixel.b), (pixel.color_a, pixel.color_b), pictures):
            assert color == tuple(picture.color[pixel.row, pixel.col])
            assert total(history) == pytest.approx(color, abs=1e-12)
            assert history.rays[0].kind == "camera" and history.rays[0].t == pytest.approx(picture.t[pixel.row, pixel.col])


def test_rays_of_another_pixel_would_be_noticed(asked):
    request, pictures = asked
    moved = followed.answer({**request, "places": [[row, col + 1, error] for row, col, error in PLACES]})
    sums = [total(p.a) for p in followed.Followed.model_validate(moved).pixels]
    assert any(abs(s - pictures[0].color[row, col]).max() > 1e-6 for s, (row, col, _) in zip(sums, PLACES))


def test_the_document_with_histories_reads_back_as_it_was_written(asked):
    found = followed.Followed.model_validate(followed.answer(asked[0]))
    again = followed.Followed.model_validate_json(found.model_dump_json())
    assert again.model_dump_json() == found.model_dump_json() and len(again.pixels) == 3


def test_where_mitsuba_agrees_its_picture_tells_the_first_hit(asked):
    request, pictures = asked
    found = followed.Followed.model_validate(followed.answer(
        {**request, "renderers": ["exact", "mitsuba-native"], "thorough": False}))
    for pixel in found.pixels:
        ray, = pixel.b.rays
        assert ray.t == pytest.approx(pictures[1].t[pixel.row, pixel.col]) and "no more is told" in pixel.b.note
        assert total(pixel.a) == pytest.approx(pixel.color_a, abs=1e-12)  # the reference is followed all the same
