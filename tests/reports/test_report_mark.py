"""A report is left as it is only if nothing that it is made from, and nothing in it, has changed."""

from pathlib import Path

import pytest

import reports
from comparisons.stability import document as stability
from reports import assemble, mark


@pytest.fixture
def html(folder, tmp_path) -> Path:
    return reports.build(folder, tmp_path / "html").parent


@pytest.fixture
def writes(monkeypatch) -> list:
    """Grows with every report that is written."""
    told, write = [], assemble._write
    monkeypatch.setattr(assemble, "_write", lambda *arguments: (told.append(1), write(*arguments)))
    return told


def test_the_same_results_are_not_written_again(folder, html, writes):
    told = []
    assert reports.build(folder, html, progress=told.append) == html / "index.html"
    assert writes == [] and told == [1.0]


@pytest.mark.parametrize("change", [
    lambda folder, html: (folder / "results.json").write_text((folder / "results.json").read_text() + " "),
    lambda folder, html: (folder / "runs" / "good.npz").unlink(),
    lambda folder, html: (folder / "runs" / "good.npz").write_bytes(b"other"),
    lambda folder, html: (html / "stale.html").write_text(""),
    lambda folder, html: (html / "report.css").unlink(),
    lambda folder, html: (html / "index.html").write_text("cut"),
    lambda folder, html: (html / mark.MARK).write_text(""),
    lambda folder, html: (html / mark.MARK).write_bytes(b"\xff\xfe"),
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
    from comparisons import results as documents

    results = documents.read(folder)
    found = {mark.fingerprint(results, folder)}
    (folder / stability.FILE).write_text("")
    found.add(mark.fingerprint(results, folder))
    (folder / stability.FILE).write_text("{}")
    found.add(mark.fingerprint(results, folder))
    monkeypatch.setattr(mark, "source_hash", lambda: "other code")
    found.add(mark.fingerprint(results, folder))
    monkeypatch.setattr(mark, "__file__", str(tmp_path / "mark.py"))  # other source of the reports
    found.add(mark.fingerprint(results, folder))
    assert len(found) == 5
