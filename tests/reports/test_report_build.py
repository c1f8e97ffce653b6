"""The report as a whole: complete, self-contained, safe, repeatable, replaced in one piece."""

import importlib
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from report_support import ERROR_AT, HOSTILE, MISMATCH_AT, NAN_AT, UNDECIDED_AT

from raytruth import reports
from raytruth.comparisons import results as documents
from raytruth.reference_tracer.errors import InputError
from raytruth.reports.figures import scale
from raytruth.reports.text.words import VERDICTS

building = importlib.import_module("raytruth.reports.build")  # the function of the same name hides it

VOID = {"meta", "link", "img", "br", "hr", "input"}


class Page(HTMLParser):
    """What a page refers to, its anchors, its visible text; fails on tags that are not closed."""

    def __init__(self, path: Path):
        super().__init__()
        self.links, self.ids, self.tags, self.open, self.text = [], [], [], [], ""
        self.feed(path.read_text(encoding="utf-8"))
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        self.links += [value for name, value in attributes if name in ("href", "src")]
        self.ids += [value for name, value in attributes if name == "id"]
        if tag not in VOID and not self.get_starttag_text().endswith("/>"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open[-1] != tag:
            return
        self.open.pop()

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)

    def handle_data(self, data):
        self.text += data


@pytest.fixture
def html(folder, tmp_path) -> Path:
    return reports.build(folder, tmp_path / "html").parent


def page_files(html: Path) -> list[Path]:
    return sorted(html.rglob("*.html"))


def contents(html: Path) -> dict[str, bytes]:
    return {str(p.relative_to(html)): p.read_bytes() for p in html.rglob("*") if p.is_file()}


def pixels(path: Path) -> np.ndarray:
    import OpenImageIO as oiio

    return oiio.ImageBuf(str(path)).get_pixels(oiio.UINT8)


def sphere_page(html: Path) -> Page:
    return Page(html / "scenes" / "figure-05-sphere.html")


def test_every_link_and_picture_is_there(html):
    pages = {path: Page(path) for path in page_files(html)}
    assert len(pages) == 8  # index, guide of two, effects, decisions, published, two scenes; no stability document, no page of it
    for path, page in pages.items():
        assert len(page.ids) == len(set(page.ids))
        for link in page.links:
            file, _, anchor = link.partition("#")
            target = (path.parent / file).resolve() if file else path
            assert target.is_file() and target.is_relative_to(html), f"{path.name}: {link}"
            if anchor and anchor.startswith("viewer&"):
                anchor = "viewer"
            if anchor:
                assert anchor in pages[target].ids, f"{path.name}: {link}"


def test_nothing_is_fetched_from_a_network(html):
    for path in [*page_files(html), html / "report.css", *html.glob("*.js")]:
        # a drawing within a style sheet names its language, and a part of itself
        text = re.sub(r"url\(\"data:image/svg\+xml,<svg xmlns='http://www.w3.org/2000/svg'[^\"]*\"\)", "", path.read_text(encoding="utf-8"))
        assert not re.search(r"https?:|//[a-z]|@import|url\(|fetch\(|XMLHttpRequest", text.replace("// ", "")), path


def test_texts_of_the_document_stay_texts(html):
    for path in page_files(html):
        page = Page(path)
        scripts = [attributes for tag, attributes in page.tags if tag == "script"]  # our own, and data that is none
        assert all(a.get("src") in {f"{'../' if path.parent != html else ''}{name}" for name in building.STATIC}
                   or a == {"type": "application/json"} for a in scripts)
        assert not any(name.startswith("on") for _, attributes in page.tags for name in attributes)
    assert sphere_page(html).text.count(HOSTILE) > 5
    assert HOSTILE in Page(html / "index.html").text


def test_no_file_lands_outside_the_report(html, tmp_path):
    assert sorted(p.name for p in tmp_path.iterdir()) == ["html", "results"]
    assert all(p.is_relative_to(html) for p in (q.resolve() for q in html.rglob("*")))


def test_error_maps_decode_to_the_errors_that_were_put_in(html):
    image = pixels(html / "images" / "errors" / "faulty.png")
    half_a_step = scale.STEP**0.5 * (1 + 1e-9)
    for place, error in ERROR_AT.items():
        levels = np.nonzero((scale.TABLE == image[place]).all(-1))[0]
        shown, expected = scale.error_of(levels[0]), np.clip(error, scale.LOW, scale.HIGH)
        assert expected / half_a_step <= shown <= expected * half_a_step
    assert (image[NAN_AT] == scale.NON_FINITE).all()
    assert (image[UNDECIDED_AT] == scale.UNDECIDED).all()
    assert (image[MISMATCH_AT] == scale.MISMATCH).all()
    faulty = [*ERROR_AT, NAN_AT, UNDECIDED_AT, MISMATCH_AT]
    image[tuple(zip(*faulty))] = scale.EXACT
    assert (image == scale.EXACT).all()


def test_equal_pictures_have_black_maps(html):
    assert (pixels(html / "images" / "errors" / "same.png") == scale.EXACT).all()


def test_the_picture_is_the_render(html, pictures):
    expected = np.floor(np.clip(pictures["good"].color, 0, 1) * 255 + 0.5)
    assert (pixels(html / "images" / "runs" / "good.png") == expected).all()


def test_the_headline_counts_everything(html):
    text = re.sub(r"\s+", " ", Page(html / "index.html").text)
    assert "Renderer bad differs from the truth on 1 of 1 scene." in text
    assert "Of 5 comparisons over 2 scenes, 2 agree, 1 differs, 1 differs as expected, and 1 could not be judged." in text
    assert "Renderer crash crashed on" in text and "signal 11" in text
    assert "no hearts here" in text.lower() and f"raytruth render {HOSTILE}" in text


def test_a_picture_that_proves_nothing_is_listed_with_the_reason(folder, tmp_path):
    results = documents.read(folder)
    told = [c.model_copy(update={"verdict": "not compared", "reason": "20 pixels differ, which tells nothing"})
            if c.id == "faulty" else c for c in results.comparisons]
    documents.write(results.model_copy(update={"comparisons": told}), folder)
    text = re.sub(r"\s+", " ", Page(reports.build(folder, tmp_path / "html")).text)
    assert "and 2 could not be judged." in text and "20 pixels differ, which tells nothing." in text
    assert "Renderer crash crashed on" in text  # without a picture: among those that are not there, and not listed twice


def test_verdicts_carry_a_word_and_a_shape(html):
    page, css = Page(html / "index.html"), (html / "report.css").read_text(encoding="utf-8")
    icons = {a["class"].split()[1] for tag, a in page.tags if tag == "i" and a.get("class", "").startswith("icon")}
    assert icons == {"agrees", "differs", "expected", "absent"}
    shapes = dict(re.findall(r"\.icon\.(\w+) \{ --shape: (.*?); \}\n", css))
    assert set(shapes) == icons and len(set(shapes.values())) == 4
    for words in VERDICTS.values():
        assert words.word in page.text


def test_a_scene_page_says_what_was_measured_and_how_to_repeat_it(html):
    text = re.sub(r"\s+", " ", sphere_page(html).text)
    for expected in ("colour p99", "0.05", "≤ 10−3", "largest difference of any linear channel", "raytruth compare",
                     "1.25 s", "768", "the model’s truth", "row 0 is the top row", "ball"):
        assert expected.replace(" ", "") in re.sub(r"\s", "", text), expected


def test_the_same_results_give_the_same_bytes(folder, tmp_path):
    first = contents(reports.build(folder, tmp_path / "a").parent)
    second = contents(reports.build(folder, tmp_path / "b").parent)
    again = contents(reports.build(folder, tmp_path / "a").parent)
    assert first == second == again


def test_a_missing_picture_costs_its_own_case_only(html):
    text = sphere_page(html).text
    assert "runs/gone.npz is missing from the folder of the results." in text
    assert not (html / "images" / "errors" / "lost.png").exists()
    assert (html / "images" / "errors" / "same.png").exists()


def test_results_without_any_picture_still_make_a_report(folder, tmp_path):
    for file in (folder / "runs").iterdir():
        file.unlink()
    html = reports.build(folder, tmp_path / "html").parent
    assert "runs/good.npz is missing" in sphere_page(html).text


def test_files_of_an_earlier_report_disappear(folder, html):
    stale = html / "images" / "stale.png"
    stale.write_bytes(b"")
    reports.build(folder, html)
    assert not stale.exists() and (html / "index.html").exists()


def test_an_interrupted_build_leaves_the_earlier_report(folder, html, monkeypatch):
    before = contents(html)
    change(folder)
    monkeypatch.setattr(building, "all_pages", lambda report: interrupt())
    with pytest.raises(KeyboardInterrupt):
        reports.build(folder, html)
    assert contents(html) == before
    assert [p.name for p in html.parent.iterdir() if p.name.startswith(".")] == []


def change(folder: Path):
    """The same results, but other bytes: a report of them has to be built anew."""
    path = folder / "results.json"
    path.write_text(path.read_text() + "\n")


def interrupt():
    raise KeyboardInterrupt


def test_a_build_interrupted_between_its_two_renames_is_mended(folder, html, monkeypatch):
    before = contents(html)
    html.rename(html.with_name(f".{html.name}.old"))
    monkeypatch.setattr(building, "all_pages", lambda report: interrupt())
    with pytest.raises(KeyboardInterrupt):  # not even a second failure loses the earlier report
        reports.build(folder, html)
    assert contents(html) == before


def test_a_folder_that_is_no_report_is_left_alone(folder, tmp_path):
    mine = tmp_path / "thesis"
    mine.mkdir()
    (mine / "chapter.txt").write_text("years of work")
    with pytest.raises(InputError, match="is not a report"):
        reports.build(folder, mine)
    with pytest.raises(InputError, match="holds the results"):
        reports.build(folder, folder)
    with pytest.raises(InputError, match="holds the results"):
        reports.build(folder, tmp_path)
    assert (mine / "chapter.txt").read_text() == "years of work" and (folder / "results.json").exists()


def test_results_of_another_version_are_refused_in_one_sentence(folder, tmp_path):
    path = folder / "results.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "version": 99}))
    with pytest.raises(InputError) as caught:
        reports.build(folder, tmp_path / "html")
    assert "has version 99" in str(caught.value) and "\n" not in str(caught.value)
    assert not (tmp_path / "html").exists()


def test_progress_rises_to_one(folder, tmp_path):
    shares = []
    reports.build(folder, tmp_path / "html", progress=shares.append)
    assert shares == sorted(shares) and shares[-1] == 1.0
