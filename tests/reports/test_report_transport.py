"""The page of light transport: pictures of both sides, the error on the fixed scale, each failure by itself."""

import re

import numpy as np
import pytest
from report_support import HOSTILE, make_results

from raytruth import reports
from raytruth.comparisons import results as documents
from raytruth.comparisons.results import Gate
from raytruth.comparisons.transport import document as transport
from raytruth.comparisons.transport.document import CaseRecord, Transport
from raytruth.reference_tracer.scene import library
from raytruth.reports.figures import scale

SHAPE = (6, 8)


def record(id: str, **changes) -> CaseRecord:
    gate = Gate(name="color p99", value=1e-6, limit=2e-5, holds=True, means=HOSTILE)
    return CaseRecord(**{"id": id, "title": f"Title {HOSTILE}", "effect": "shadow", "kind": "equal", "because": HOSTILE,
                         "judged": "deterministic", "width": SHAPE[1], "height": SHAPE[0], "key": id, "state": "ok",
                         "holds": True, "reason": f"because of {id}", "gates": [gate], "metrics": {"pixels": 48},
                         "planes": f"transport/{id}.npz", "command": f"raytruth transport {id}", **changes})


def planes(path, **changes):
    document = np.full((*SHAPE, 3), 0.5)
    mitsuba = document.copy()
    mitsuba[2, 3, 1] += 1e-4
    compared = np.ones(SHAPE, bool)
    compared[0] = False
    path.parent.mkdir(exist_ok=True)
    with path.open("wb") as file:
        np.savez(file, **{"document": document, "mitsuba": mitsuba, "expected": document, "compared": compared,
                          **changes})


@pytest.fixture
def page(folder, tmp_path):
    def build(*cases):
        machine = make_results(library.scene("figure-05-sphere")).machine
        transport.keep(Transport(created="c", seconds=1, machine=machine, cases=list(cases)), folder)
        html = reports.build(folder, tmp_path / "html").parent
        return html, (html / "transport.html").read_text(encoding="utf-8")
    return build


def test_both_sides_and_their_error_on_the_fixed_scale(folder, page):
    import OpenImageIO as oiio

    planes(folder / "transport" / "whole.npz")
    html, text = page(record("whole"), record("law", kind="finding", planes=None))
    for side in ("document", "mitsuba", "error"):
        assert f"images/transport/whole-{side}.png" in text
    pixels = oiio.ImageBuf(str(html / "images/transport/whole-error.png")).get_pixels(oiio.UINT8)
    assert (pixels[2, 3] == scale.TABLE[scale.level(1e-4)]).all() and (pixels[3, 3] == scale.EXACT).all()
    assert (pixels[0] == 96).all()
    assert re.search(r"<span class=\"n\">83\.3</span>&#8239;% of the pixels are compared", text)  # 5 of 6 rows
    assert "1 of 1 agree" in text and "Differs as expected" in text and HOSTILE not in text
    assert "transport.html" in (html / "index.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("change, words", [
    ({"planes": None, "state": "crashed", "holds": False, "message": "signal 11"}, "signal 11"),
    ({"planes": "transport/gone.npz"}, "is missing"), ({"planes": "../../etc/passwd"}, "lies outside"),
    ({"planes": "transport/odd.npz"}, "holds no picture"), ({"planes": "transport/text.npz"}, "cannot be read")])
def test_a_case_without_pictures_costs_itself_only(folder, page, change, words):
    planes(folder / "transport" / "whole.npz")
    planes(folder / "transport" / "odd.npz", mitsuba=np.zeros((3, 3, 3)))
    (folder / "transport" / "text.npz").write_text("rubbish")
    html, text = page(record("whole"), record("broken", **change))
    assert words in text and "images/transport/whole-error.png" in text
    assert sorted(p.name for p in (html / "images/transport").iterdir()) == [
        "whole-document.png", "whole-error.png", "whole-mitsuba.png"]


def test_without_the_document_there_is_no_page(folder, tmp_path):
    documents.read(folder)
    html = reports.build(folder, tmp_path / "html").parent
    assert not (html / "transport.html").exists()
    assert "transport.html" not in (html / "index.html").read_text(encoding="utf-8")
