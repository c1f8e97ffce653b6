"""Builds a report in a folder beside the last one, then puts it in its place."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from comparisons import results as comparison
from reference_tracer.errors import InputError
from reference_tracer.tracer.image_files import write_8_bit

from . import mark, pictures, templating
from .documents import read_all
from .mark import MARK
from .pages import all_pages
from .report import arrange

OUTPUT = Path("reports/html")
MOST_THREADS = 4  # each holds the planes of one scene, about 200 MB; packing and unpacking run in parallel


def build(results_folder: str | Path, output_folder: str | Path = OUTPUT, *,
          progress: Callable[[float], None] | None = None) -> Path:
    """Makes the report of the results in `results_folder`; returns the path of its first page.

    The same results give the same bytes, and a report made from the same results is left as it is. An earlier
    report in `output_folder` is replaced as a whole, and stays as it is until the new one is complete. `progress` is
    called with the finished fraction. Raises InputError.
    """
    results_folder, output = Path(results_folder), Path(output_folder).resolve()
    results = comparison.read(results_folder)
    report = arrange(results, read_all(results_folder), results_folder)
    _require_ours(output, results_folder.resolve())
    made_from = mark.fingerprint(results, results_folder)
    if mark.is_current(output, made_from):
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
        _write(report, results_folder, new, progress or (lambda _: None))
        mark.write(new, made_from)
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
    if output.exists() and not (output.is_dir() and ((output / MARK).exists() or not any(output.iterdir()))):
        raise InputError(f"{output}: exists and is not a report; remove it or choose another folder")


def _write(report, results_folder: Path, folder: Path, progress: Callable[[float], None]) -> None:
    pictures.write_scale(folder)
    scenes = report.results.scenes
    with ThreadPoolExecutor(min(MOST_THREADS, os.cpu_count() or 1)) as pool:
        written = pool.map(lambda scene: pictures.write_scene(
            report.of_scene(scene), report.effects_of_scene(scene), results_folder, folder), scenes)
        for done, (scene, files) in enumerate(zip(scenes, written), 1):
            report.pictures[scene.name] = files
            progress(done / (len(scenes) + 1))
    templates = templating.environment()
    pages = all_pages(report)
    files = {page.path: templating.rendered(templates, page, report, pages) for page in pages}
    for path, pixels in {path: pixels for page in pages for path, pixels in page.pictures.items()}.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        write_8_bit(pixels, folder / path)
    for path, text in {**files, **templating.static(templates)}.items():
        (folder / path).parent.mkdir(exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8", newline="\n")
    progress(1.0)
