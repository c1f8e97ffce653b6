"""What the text says and the figures show: every switch, every figure with its numbers, pictures where they were made."""

import re

import pytest
from report_support import make_results

from raytruth import reports
from raytruth.comparisons import results as documents
from raytruth.comparisons.results import Effect
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.model import Camera, Tracing
from raytruth.reports.pages.decisions import read_decisions
from raytruth.reports.pages.published import SWITCHES, Figure, read


def test_switches_are_decisions_and_keys_of_the_format():
    rows = {decision.id for decision in read_decisions()}
    for switch in SWITCHES:
        assert switch.id in rows
        for key in filter(None, switch.key.split(", ")):
            part, name = key.split(".")
            assert name in {"tracing": Tracing, "camera": Camera}[part].model_fields


def test_numbers_tell_of_the_switches_that_each_figure_has():
    numbers = read()
    assert set(numbers) == set(library.names())
    for name, found in numbers.items():
        form = library.scene(name).figure_form()
        assert {s["id"] for s in found["switches"]} == set(form.switches), name
        off = 100 - found["figure_form"]["within_1"]
        assert sum(found["left"].values()) == pytest.approx(off / 100 * found["pixels"], abs=0.01 + 0.0001 / 100 * found["pixels"])


def test_a_figure_tells_what_a_switch_changes_and_nothing_of_those_it_lacks():
    figure = Figure("figure-05-sphere", {"switches": [{"id": "F1", "alone": 12.5}], "left": {"silhouette": 3, "belt": 1}})
    assert figure.changed("F1") == 12.5 and figure.changed("F2") is None
    assert figure.left == "3 silhouette, 1 belt"


def test_the_page_has_a_row_a_figure_and_the_pair_of_pictures_of_a_switch(folder, tmp_path):
    shown = Effect(id="lights", decision="F1", scene="figure-05-sphere", change="balanced", finding="it is darker",
                   baseline="good", variant="bad", metrics={"color max": 7.0})
    documents.write(make_results(library.scene("figure-05-sphere")).model_copy(update={"effects": [shown]}), folder)
    html = reports.build(folder, tmp_path / "html").parent
    page = (html / "published.html").read_text(encoding="utf-8")
    assert page.count('id="lights"') == 1 and "It is darker." in page and "images/effects/lights.png" in page
    for name, found in read().items():
        row = re.search(rf"<tr><th scope=\"row\">(?:<a [^>]*>)?{re.escape(name)}.*?</tr>", page).group()
        assert f"{found['figure_form']['within_1']:.3f}" in row and f"{found['text_form']['within_1']:.1f}" in row
