"""A report is left as it is only if nothing that it is made from, and nothing in it, has changed."""

import importlib
import shutil
from pathlib import Path

import pytest

from raytruth import reports
from raytruth.comparisons.stability import document as stability

building = importlib.import_module("raytruth.reports.build")  # the function of the same name hides it


@pytest.fixture
def html(folder, tmp_path) -> Path:
    return reports.build(folder, tmp_path / "html").parent


@pytest.fixture
def writes(monkeypatch) -> list:
    """Grows with every report that is written."""
    calls, write = [], building._write
    monkeypatch.setattr(building, "_write", lambda *arguments: (calls.append(1), write(*arguments)))
    return calls


def test_the_same_results_are_not_written_again(folder, html, writes):
    shares = []
    assert reports.build(folder, html, progress=shares.append) == html / "index.html"
    assert writes == [] and shares == [1.0]


@pytest.mark.parametrize("change", [
    lambda folder, html: (folder / "results.json").write_text((folder / "results.json").read_text() + " "),
    lambda folder, html: (folder / "runs" / "good.npz").unlink(),
    lambda folder, html: (folder / "runs" / "good.npz").write_bytes(b"other"),
    lambda folder, html: (html / "stale.html").write_text(""),
    lambda folder, html: (html / "report.css").unlink(),
    lambda folder, html: (html / "index.html").write_text("cut"),
    lambda folder, html: (html / building.STAMP).write_text(""),
    lambda folder, html: (html / building.STAMP).write_bytes(b"\xff\xfe"),
])
def test_any_change_of_source_or_report_builds_it_anew(folder, html, writes, change):
    change(folder, html)
    reports.build(folder, html)
    assert writes == [1]
    assert not (html / "stale.html").exists() and (html / "report.css").exists()
    assert len((html / "index.html").read_text()) > 1000
    reports.build(folder, html)
    assert writes == [1]


def test_documents_and_source_are_in_the_fingerprint(folder, monkeypatch, tmp_path):
    from raytruth.comparisons import results as documents

    results = documents.read(folder)
    found = {building.fingerprint(results, folder)}
    (folder / stability.FILE).write_text("")
    found.add(building.fingerprint(results, folder))
    (folder / stability.FILE).write_text("{}")
    found.add(building.fingerprint(results, folder))
    monkeypatch.setattr(building, "source_hash", lambda: "other code")
    found.add(building.fingerprint(results, folder))
    (tmp_path / "templates").mkdir()
    (tmp_path / "published.json").write_text("{}")
    monkeypatch.setattr(building, "__file__", str(tmp_path / "build.py"))  # other source of the reports
    found.add(building.fingerprint(results, folder))
    assert len(found) == 5


def test_pictures_of_scenes_that_have_not_changed_are_taken_over(folder, html, monkeypatch, tmp_path):
    from raytruth.comparisons import results as documents

    made = []
    write = building.pictures.write_scene
    monkeypatch.setattr(building.pictures, "write_scene",
                        lambda cases, *more: (made.append({case.scene.name for case in cases}), write(cases, *more))[1])
    results = documents.read(folder)
    documents.write(results.model_copy(update={"created": "later"}), folder)
    reports.build(folder, html)
    assert made == [] and "later" in (html / "index.html").read_text()
    assert reports.build(folder, tmp_path / "anew").exists() and made
    files = lambda report: {p.relative_to(report): p.read_bytes() for p in report.rglob("*") if p.is_file()}
    assert files(html) == files(tmp_path / "anew")
    made.clear()
    changed = [c.model_copy(update={"worst": []}) for c in results.comparisons]
    documents.write(results.model_copy(update={"comparisons": changed}), folder)
    reports.build(folder, html)
    assert made == [{"figure-05-sphere"}]
    made.clear()
    next((html / "planes").iterdir()).write_bytes(b"cut")  # a report that is not whole gives nothing
    reports.build(folder, html)
    assert {"figure-05-sphere"} in made


def test_a_report_in_the_checkout_is_not_made_from_itself(tmp_path, monkeypatch):
    """By default it is written to reports/html, beside the code that makes it."""
    here = Path(building.__file__).parent
    for part in ("text", "templates"):
        shutil.copytree(here / part, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(here / "published.json", tmp_path)
    monkeypatch.setattr(building, "__file__", str(tmp_path / "build.py"))
    before = building._code()
    (tmp_path / "html" / "pages").mkdir(parents=True)
    for name in ("index.html", "viewer.js", "pages/scene.html", building.STAMP):
        (tmp_path / "html" / name).write_text("made")
    assert building._code() == before
    for name in ("text/words.py", "templates/viewer.js", "templates/scene.html.j2", "published.json"):
        (tmp_path / name).write_text((tmp_path / name).read_text() + "\n")
        assert building._code() != before
        before = building._code()
