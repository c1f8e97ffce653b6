"""The pages under docs/ and README: their commands run, their examples load, their links lead somewhere."""

import contextlib
import io
import json
import re
import shlex
import shutil
import sys
from pathlib import Path

import pytest

from raytruth.cli import main
from raytruth.reference_tracer.scene.load import load_scene

HERE = Path(__file__).resolve().parents[2]
PAGES = sorted([*(HERE / "docs").rglob("*.md"), HERE / "README.md"])
sys.path.insert(0, str(HERE / "docs"))


def blocks(page: Path, kind: str) -> list[str]:
    return re.findall(rf"^```{kind}\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+ (.*)", page.read_text(encoding="utf-8"), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", h.lower()).strip().replace(" ", "-") for h in headings}


def typed(page: Path):
    """The commands of a page, each with what the page says that the terminal answers, if it says so."""
    for text in blocks(page, "console"):
        for part in re.split(r"^\$ ", text, flags=re.M)[1:]:
            line, _, said = part.partition("\n")
            yield line, said.strip("\n")


def of_any_machine(said: str) -> str:
    """Without the numbers that rounding and time decide, and the spaces of columns that they stand in."""
    return re.sub(r"\s+", " ", re.sub(r"[\d.]+ s\b|\d+(\.\d+)?e-\d+|up to \d+%", "#", said)).strip()


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "console")], ids=lambda p: p.name)
def test_commands_run_and_say_what_the_page_says(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    for text in blocks(page, "json"):
        if "name" in (scene := json.loads(text)):
            Path(f"{scene['name']}.json").write_text(text, encoding="utf-8")
    absent = not shutil.which("povray")
    for line, said in typed(page):
        assert line.startswith("raytruth "), line
        if absent and ("--with povray" in line or "witness" in line):  # its picture, and what is asked of it
            continue
        with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as told:
            code = main(shlex.split(line)[1:])
        if said.startswith("raytruth: "):  # a refusal
            assert (code, of_any_machine(told.getvalue())) == (2, of_any_machine(said))
            continue
        # `doctor` finds what a machine lacks, `compare` what differs: both are answers
        assert code == 0 or (code == 1 and line.split()[1] in ("doctor", "compare")), f"{line}: {out.getvalue()}"
        if said and not (absent and "povray" in line):
            assert of_any_machine(out.getvalue()) == of_any_machine(said), line


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "json")], ids=lambda p: p.name)
def test_examples_load(page, tmp_path):
    for text in blocks(page, "json"):
        example = json.loads(text)
        scene = example if "objects" in example else {"name": "example", "objects": [example]}
        (tmp_path / "example.json").write_text(json.dumps(scene))
        load_scene(tmp_path / "example.json")


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if target.startswith(("http:", "https:")):
            continue
        path, _, anchor = target.partition("#")
        found = (page.parent / path).resolve() if path else page
        assert found.exists(), f"{page.name}: {target}"
        assert not anchor or anchor in anchors(found), f"{page.name}: {target}"


def test_the_format_is_told_whole():
    from generate import MARKER, PARTS, keys, on_page_markdown

    scenes = (HERE / "docs/scenes.md").read_text(encoding="utf-8")
    assert MARKER in scenes
    page = on_page_markdown(scenes)
    assert keys() in page and MARKER not in page
    for part in PARTS:
        for name, field in part.model_fields.items():
            assert f"| `{field.alias or name}` |" in page
