"""What decisions change: the misprint first and always there, each effect with its map, each failure by itself."""

import math

import numpy as np
import pytest
from report_support import ERROR_AT, make_results

from raytruth import reports
from raytruth.comparisons import results as documents
from raytruth.comparisons.results import Effect
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.tracer.image_files import to_8_bit
from raytruth.reports.cases import effects
from raytruth.reports.figures import scale
from raytruth.reports.pages.decisions import (
    Decision,
    by_decision,
    last_printed_angle,
    printed_direction,
    refracted,
    refraction_chart,
    refraction_curves,
)

DECISIONS = [Decision("C2", "5", "q", "d"), Decision("E1", "4", "q", "d"), Decision("M6", "4", "q", "d")]


def effect(id: str, decision="M6", baseline="good", variant="bad", scene="figure-05-sphere") -> Effect:
    return Effect(id=id, decision=decision, scene=scene, change="something else", finding=f"finding of {id}",
                  baseline=baseline, variant=variant, metrics={"color max": 7.0})


def with_effects(*found: Effect):
    return make_results(library.scene("figure-05-sphere")).model_copy(update={"effects": list(found)})


def test_the_misprint_comes_first_even_unmeasured_then_the_order_of_the_decisions():
    shown = effects(with_effects(effect("a", "Z9"), effect("b", "M6"), effect("c", "C2"), effect("d", "M6")))
    groups = by_decision(shown, DECISIONS)
    assert [(g.id, [s.effect.id for s in g.effects]) for g in groups] == [
        ("E1", []), ("C2", ["c"]), ("M6", ["b", "d"]), ("Z9", ["a"])]
    assert groups[-1].decision is None


@pytest.mark.parametrize("broken, words", [
    (effect("x", variant="nobody"), "do not list the run"), (effect("x", scene="nowhere"), "do not list the scene"),
    (effect("x", baseline="crash"), "signal 11"), (effect("x", variant="gone"), "runs/gone.npz is missing")])
def test_a_missing_or_failed_run_costs_its_effect_only(folder, tmp_path, broken, words):
    documents.write(with_effects(broken, effect("whole")), folder)
    html = reports.build(folder, tmp_path / "html").parent
    page = (html / "effects.html").read_text(encoding="utf-8").replace("&#39;", "'")
    assert words in page and "Finding of x." in page
    assert sorted(p.name for p in (html / "images" / "effects").iterdir()) == ["whole.png"]


def test_an_effect_shows_both_pictures_and_their_errors_on_the_fixed_scale(folder, tmp_path, pictures):
    import OpenImageIO as oiio

    documents.write(with_effects(effect("whole", "E1")), folder)
    html = reports.build(folder, tmp_path / "html").parent
    page = (html / "effects.html").read_text(encoding="utf-8")
    for file in ("images/runs/good.png", "images/runs/bad.png", "images/effects/whole.png"):
        assert file in page
    image = oiio.ImageBuf(str(html / "images/effects/whole.png")).get_pixels(oiio.UINT8)
    for place, error in ERROR_AT.items():
        assert (image[place] == scale.TABLE[scale.level(error)]).all()


def test_a_run_that_only_an_effect_shows_has_its_colours_alone(folder, tmp_path, pictures):
    results = with_effects(effect("whole", variant="paper"))
    compared = [c for c in results.comparisons if c.test != "paper"]
    documents.write(results.model_copy(update={"comparisons": compared}), folder)
    html = reports.build(folder, tmp_path / "html").parent
    assert [p.name for p in html.rglob("paper*")] == ["paper.png"]
    import OpenImageIO as oiio

    shown = oiio.ImageBuf(str(html / "images/runs/paper.png")).get_pixels(oiio.UINT8)
    assert np.array_equal(shown, to_8_bit(pictures["paper"].color))


def test_decisions_link_to_what_they_change(folder, tmp_path):
    documents.write(with_effects(effect("whole", "M6")), folder)
    html = reports.build(folder, tmp_path / "html").parent
    decisions, page = ((html / f"{name}.html").read_text(encoding="utf-8") for name in ("decisions", "effects"))
    for id in ("E1", "M6"):
        assert f'href="effects.html#{id}"' in decisions
        assert f'href="decisions.html#{id}"' in page and f'id="{id}"' in page
    assert 'href="effects.html#C1"' not in decisions


def test_the_two_formulas():
    # n = 1.5, 30 degrees: sin = 0.5 / 1.5 = 1/3 by the law, 0.75 as printed
    assert math.sin(math.radians(refracted(30, 1 / 1.5))) == pytest.approx(1 / 3, rel=1e-12)
    assert math.sin(math.radians(refracted(30, 1.5))) == pytest.approx(0.75, rel=1e-12)
    assert refracted(42, 1.5) is None and refracted(90, 1 / 1.5) is not None
    assert math.sin(math.radians(last_printed_angle())) == pytest.approx(2 / 3, rel=1e-12)


def test_the_direction_of_the_printed_formula_is_that_of_the_documents_vectors():
    # d = (sin 30, -cos 30), normal (0, 1), cos phi2 = sqrt(1 - 0.75^2): (d + n cos phi1) / 1.5 - n cos phi2
    d, normal = np.array([0.5, -math.sqrt(3) / 2]), np.array([0.0, 1.0])
    direction = (d + normal * math.sqrt(3) / 2) / 1.5 - normal * math.sqrt(1 - 0.75**2)
    length, angle = printed_direction(30)
    assert length == pytest.approx(np.hypot(*direction), rel=1e-12)
    assert math.tan(math.radians(angle)) == pytest.approx(direction[0] / -direction[1], rel=1e-12)


def test_the_chart_of_the_misprint_ends_where_its_sine_is_one():
    law, printed, direction, straight = (line.points for line in refraction_curves())
    assert printed[-1] == direction[-1] == (last_printed_angle(), 90.0)
    assert law[-1][0] == straight[-1][0] > printed[-1][0]
    assert law[-1][1] == pytest.approx(last_printed_angle(), rel=1e-12)  # of a grazing ray: asin(2/3)
    svg = refraction_chart()
    for label in ("the law, n₁/n₂", "the sine as printed", "no refraction", "90°"):
        assert label in svg
