"""Builds a report in a folder beside the last one, then puts it in its place."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from raytruth.comparisons import results as comparison
from raytruth.comparisons.execution.machine import packages, source_hash
from raytruth.comparisons.results import Results, SceneRecord
from raytruth.reference_tracer.errors import InputError

from . import kept
from .cases import is_lower_bound, scene_page
from .figures import pictures, png, scale
from .figures.pictures import ScenePictures
from .pages import READERS, Page, Report, all_pages, arrange
from .pages.decisions import prose
from .text import words
from .text.numbers import parts, powers

OUTPUT = Path("reports/html")
STAMP = ".raytruth-report"  # a file in every report: what it was made from; a folder without it is not ours to replace
STATIC = ("report.css", "report.js", "planes.js", "errors.js", "export.js", "viewer.js", "filter.js")  # copied as they are
MOST_THREADS = 4  # each holds the planes of one scene, about 200 MB; packing and unpacking run in parallel


def build(results_folder: str | Path, output_folder: str | Path = OUTPUT, *, against: str | Path | None = None,
          to_come: int = 0, progress: Callable[[float], None] | None = None) -> Path:
    """Makes the report of the results in `results_folder`; returns the path of its first page.

    The same results give the same bytes, and a report made from the same results is left as it is. An earlier
    report in `output_folder` is replaced as a whole, and stays as it is until the new one is complete, which takes over
    the pictures of scenes that have not changed. `progress` is called with the finished fraction. `against` is a folder
    of earlier results, which changes are told against; `to_come` comparisons are still under way. Raises InputError.
    """
    results_folder, output = Path(results_folder), Path(output_folder).resolve()
    results = comparison.read(results_folder)
    report = arrange(results, {
        name: read(results_folder) for name, read in READERS.items() if (results_folder / name).exists()}, results_folder,
        comparison.read(against) if against is not None else None, to_come)
    _require_ours(output, results_folder.resolve())
    made_from = fingerprint(results, results_folder, against, to_come)
    if is_current(output, made_from):
        if progress is not None:
            progress(1.0)
        return output / "index.html"
    new, old = output.with_name(f".{output.name}.new"), output.with_name(f".{output.name}.old")
    try:
        if old.exists() and not output.exists():  # a build was interrupted between the two renames below
            os.replace(old, output)
        for leftover in (new, old):
            shutil.rmtree(leftover, ignore_errors=True)
        new.mkdir(parents=True)
        _write(report, results_folder, new, output, progress or (lambda _: None))
        (new / STAMP).write_text(_stamp(new, made_from), encoding="utf-8", newline="\n")
        if output.exists():
            os.replace(output, old)
        os.replace(new, output)
        shutil.rmtree(old, ignore_errors=True)
    except OSError as error:
        raise InputError(f"{output}: the report cannot be written ({error.strerror or error})") from None
    finally:
        shutil.rmtree(new, ignore_errors=True)
    return output / "index.html"


def _require_ours(output: Path, results: Path) -> None:
    if results == output or output in results.parents:
        raise InputError(f"{output}: holds the results, which a report would replace; choose another folder")
    if output.exists() and not (output.is_dir() and ((output / STAMP).exists() or not any(output.iterdir()))):
        raise InputError(f"{output}: exists and is not a report; remove it or choose another folder")


def _write(report: Report, results_folder: Path, folder: Path, earlier: Path, progress: Callable[[float], None]) -> None:
    pictures.write_scale(folder)
    scenes, code = report.results.scenes, _code()
    before = kept.read(earlier) if is_whole(earlier) else {}
    made_from = {scene.name: kept.made_from(report, scene, results_folder, code) for scene in scenes}

    def write(scene: SceneRecord) -> ScenePictures:
        return kept.taken_over(before.get(scene.name), made_from[scene.name], earlier, folder) or pictures.write_scene(
            report.of_scene(scene), report.effects_of_scene(scene), results_folder, folder)

    with ThreadPoolExecutor(min(MOST_THREADS, os.cpu_count() or 1)) as pool:
        for done, (scene, files) in enumerate(zip(scenes, pool.map(write, scenes)), 1):
            report.pictures[scene.name] = files
            progress(done / (len(scenes) + 1))
    kept.write(report.pictures, made_from, folder)
    templates = environment()
    pages = all_pages(report)
    files = {page.path: rendered(templates, page, report, pages) for page in pages}
    for path, pixels in {path: pixels for page in pages for path, pixels in page.pictures.items()}.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        png.write(pixels, folder / path)
    tables = {path: text for page in pages for path, text in page.tables.items()}
    for path, text in {**files, **tables, **static(templates)}.items():
        (folder / path).parent.mkdir(exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8", newline="\n")
    progress(1.0)


def environment() -> Environment:
    templates = Environment(loader=PackageLoader("raytruth.reports"), autoescape=True, undefined=StrictUndefined,
                            trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True)
    templates.filters.update(parts=parts, powers=powers, page_of=scene_page, prose=prose, **{
        name: getattr(words, name) for name in ("metric", "full_stop", "sentence", "capital", "slug")})
    templates.tests.update(lower_bound=is_lower_bound)
    templates.globals.update(scale=scale, VERDICTS=words.VERDICTS, STATES=words.STATES,
                             KEY_METRICS=words.KEY_METRICS, count=words.count)
    return templates


def rendered(templates: Environment, page: Page, report: Report, pages: list[Page]) -> str:
    """`page` as HTML; `pages` are those its bar may lead to."""
    bar = [p for p in pages if p.nav]
    first = {p.section: p for p in reversed(bar)}
    return templates.get_template(page.template).render(
        report=report, root=page.root, path=page.path, bar=bar, section=page.section,
        sections=[(name, first[name]) for name in dict.fromkeys(p.section for p in bar)], **page.content)


def static(templates: Environment) -> dict[str, str]:
    """The files that are copied as they are: name to text."""
    return {name: templates.loader.get_source(templates, name)[0] for name in STATIC}


def fingerprint(results: Results, folder: Path, against: str | Path | None = None, to_come: int = 0) -> str:
    """A hash of all that can change a report: the documents, the sizes of the planes, all code, the packages.

    Names of planes are hashes of what can change them, so that their contents need not be read.
    """
    digest = hashlib.sha256(f"{_code()} {to_come}\n".encode())
    for name in (comparison.FILE, *READERS):
        path = folder / name
        content = path.read_bytes() if path.is_file() else b""
        digest.update(f"{name} {path.is_file()} {len(content)}\n".encode() + content)
    if against is not None:
        digest.update((Path(against) / comparison.FILE).read_bytes())
    for run in results.runs:
        digest.update(kept.size(run, folder).encode())
    return digest.hexdigest()


def _code() -> str:
    """A hash of all code, templates and packages."""
    digest = hashlib.sha256(json.dumps([packages(), source_hash()], sort_keys=True).encode())
    here = Path(__file__).parent  # in a checkout, OUTPUT lies in it too: a report is not made from itself
    for file in sorted([*here.rglob("*.py"), *(here / "templates").iterdir(), here / "published.json"]):
        digest.update(f"{file.relative_to(here).as_posix()} {file.stat().st_size}\n".encode() + file.read_bytes())
    return digest.hexdigest()


def is_whole(report: Path) -> bool:
    """Whether `report` holds a report with no file lost, added or of another size."""
    try:
        return is_current(report, (report / STAMP).read_text(encoding="utf-8").partition("\n")[0])
    except (OSError, ValueError):
        return False


def is_current(report: Path, made_from: str) -> bool:
    """Whether `report` holds a report made from exactly that, with no file lost, added or of another size."""
    try:
        return (report / STAMP).read_text(encoding="utf-8") == _stamp(report, made_from)
    except (OSError, ValueError):
        return False


def _stamp(report: Path, made_from: str) -> str:
    """`made_from`, and a hash of the names and sizes of all files of the report but the stamp."""
    files = sorted(p for p in report.rglob("*") if p.is_file() and p.name != STAMP)
    lines = (f"{p.relative_to(report).as_posix()} {p.stat().st_size}\n" for p in files)
    return f"{made_from}\n{hashlib.sha256(''.join(lines).encode('utf-8', 'surrogatepass')).hexdigest()}\n"
