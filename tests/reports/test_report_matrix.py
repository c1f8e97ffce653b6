"""The page of all pairs: what a cell says, who is marked, reasons in words, untrusted texts escaped."""

import re

from report_support import HOSTILE, make_results

from raytruth.comparisons.agreement.matrix import matrix as build_matrix
from raytruth.comparisons.agreement.records import Absent, Dissent, Matrix, Member, Pair, Place, Tightness, write
from raytruth.reports.build import environment, rendered
from raytruth.reports.figures import scale
from raytruth.reports.figures.scale import css
from raytruth.reports.pages import arrange
from raytruth.reports.pages.matrix import exponent, pages, shown


def pair(first, second, p99, agrees=True, scene="ball", broken=""):
    return Pair(scene=scene, first=first, second=second, agrees=agrees, tolerance="meshes", broken=broken, color_p99=p99,
                color_max=p99, inner_max=p99, failing=3, mismatches=1, depth_p99=p99)


def document(**parts) -> Matrix:
    members = [Member(name=n, title=f"Renderer {n}", implementation=n) for n in ("exact", "mesh", "gone")]
    return Matrix(**{"members": members, "command": "raytruth compare",
                     "places": [Place(name="ball", title=f"Ball {HOSTILE}", pixels=100, effect=False),
                                Place(name="effect-shadow", title="Shadow", pixels=100, effect=True)],
                     "pairs": [pair("exact", "mesh", 2e-5), pair("exact", "mesh", 3e-2, False, "effect-shadow", "too far")],
                     "absent": [Absent(scene=s, renderer="gone", state="refused", reason=f"no {HOSTILE}")
                                for s in ("ball", "effect-shadow")],
                     "dissent": [Dissent(scene="effect-shadow", renderers=["mesh"], against=["exact"], expected=False,
                                         sentence=f"mesh is wrong {HOSTILE}")], **parts})


def test_a_cell_is_the_power_of_ten_that_the_error_stays_below():
    assert [exponent(x) for x in (1.0, 0.99, 1e-3, 1.01e-3, 2e-5)] == ["0", "0", "−3", "−2", "−4"]
    table = shown(document()).groups[0][1][0]
    cell = table.rows[0].cells[1]
    assert (cell.text, cell.style, cell.colour) == ("−4", "agree", css(scale.TABLE[scale.level(2e-5)]))
    assert table.rows[1].cells[0] == cell and table.rows[0].cells[0].style == "same"
    assert table.rows[0].cells[2].style == "absent"


def test_all_scenes_at_once_shows_the_worst_scene_and_counts_the_others():
    cell = shown(document()).overall.rows[0].cells[1]
    assert (cell.text, cell.style) == ("−1", "disagree") and "agree on 1 of 2 scenes" in cell.title
    assert "furthest apart on effect-shadow" in cell.title


def test_equal_and_not_finite_are_no_powers_of_ten():
    cells = [shown(document(pairs=[pair("exact", "mesh", p)])).groups[0][1][0].rows[0].cells[1] for p in (0.0, None)]
    assert [c.text for c in cells] == ["=", "?"]


def test_reasons_are_gathered_by_renderer():
    reason, = shown(document()).absent
    assert (reason.renderer, reason.state.word, reason.state.is_fault) == ("gone", "Refused", False)
    assert len(reason.scenes) == 2


def test_the_finding_counts_pairs_and_scenes():
    assert shown(document()).finding == "1 of 2 pairs agree; on 1 scene somebody is at odds with the others."
    expected = document(dissent=[Dissent(scene="ball", renderers=["paper"], against=["exact"], expected=True, sentence="s")])
    assert shown(expected).finding == "1 of 2 pairs agree; all others are the literal method’s misses."
    assert shown(document(dissent=[], pairs=[pair("exact", "mesh", 1e-6)])).finding == "1 of 1 pair agree."


def test_the_page_escapes_and_marks(tmp_path):
    from raytruth.reference_tracer.scene import library

    rows = [Tightness(tolerance="meshes", gate="color p99", limit=1e-3, unit="linear", scene="ball", share=0.3,
                      worse=HOSTILE, worse_scene="ball", worse_share=s, verdict=v, command="c")
            for s, v in ((1.4, "tight"), (float("inf"), "tight"), (0.2, "loose"))]
    found = document(tightness=rows)
    report = arrange(make_results(library.scene("figure-05-sphere")), {"matrix.json": found}, tmp_path)
    page, = pages(report)
    html = rendered(environment(), page, report, [page])
    assert HOSTILE not in html and "<script>alert" not in html
    assert len(re.findall(r'<tr class="odd">', html)) == 1 and "Odd one out" in html
    assert html.count(">Tight<") == 2 and html.count(">Loose<") == 1 and "∞" in html
    assert 'class="pair absent"' in html and "Refused" in html
    assert pages(arrange(make_results(library.scene("figure-05-sphere")), {}, tmp_path)) == []
    assert build_matrix and write(found, tmp_path).exists()
