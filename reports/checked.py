"""The page of one check, of a port or of a finished picture: one file that opens from disk and refers to nothing else."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from raytruth.comparisons.execution.store import atomically
from raytruth.comparisons.ports.document import GOOD
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.tracer.image_files import to_8_bit

from .build import environment, static
from .figures import maps, pictures, png, scale
from .single import data

STYLES = {"pass": "agrees", "acceptable": "expected", "skipped": "absent"}  # anything else differs


@dataclass(frozen=True)
class Beside:
    """A picture beside its truth: colours (h, w, 3), the others (h, w)."""

    title: str
    truth: np.ndarray
    shown: np.ndarray
    nothing: np.ndarray  # neither hits anything
    mismatch: np.ndarray  # another object, where the picture tells
    undecided: np.ndarray


@dataclass(frozen=True)
class Row:
    """One case: its verdict, and lines that begin with its name."""

    verdict: str
    lines: tuple[str, ...]

    @property
    def style(self) -> str:
        return STYLES.get(self.verdict, "differs")


def write(path: Path, title: str, holds: bool, lines: Sequence[str], causes: Sequence[str], rows: Sequence[Row],
          shown: Sequence[Beside]) -> None:
    """Writes the page: `lines` say what was found, `causes` the likely mistakes. Raises InputError."""
    templates = environment()
    with tempfile.TemporaryDirectory(prefix="raytruth-") as name:
        folder = Path(name)
        pictures.write_scale(folder)
        content = {"title": title, "style": "agrees" if holds else "differs", "lines": lines, "causes": causes,
                   "rows": sorted(rows, key=lambda row: row.verdict in (*GOOD, "skipped")),
                   "beside": [_written(folder, k, pair) for k, pair in enumerate(shown)]}
        text = templates.get_template("checked.html.j2").render(content, css=static(templates)["report.css"])
        # a browser follows no link to what stands in a page
        text = re.sub(r'<a href="images/[^"]*">(<img.*?)</a>', r"\1", text)
        text = re.sub(r'<img src="([^"]+)"', lambda m: f'<img src="{data(folder / m[1])}"', text)
        try:
            with atomically(path) as part:
                part.write_text(text, encoding="utf-8", newline="\n")
        except OSError as error:
            raise InputError(f"{path}: cannot be written ({error.strerror or error})") from None


def _written(folder: Path, k: int, pair: Beside) -> tuple[str, pictures.RunPictures, pictures.RunPictures, pictures.Map]:
    files = []
    for name, color in (("truth", pair.truth), ("shown", pair.shown)):
        files.append(pictures.RunPictures(f"images/{name}-{k}.png", color.shape[1], color.shape[0], 0))
        png.write(to_8_bit(color), folder / files[-1].file)
    error, file = maps.color_error(pair.truth, pair.shown), f"images/errors-{k}.png"
    png.write(scale.paint(error, pair.mismatch, pair.undecided), folder / file)
    errors = maps.Errors(error, pair.nothing, pair.mismatch, pair.undecided)
    return pair.title, *files, pictures.Map(file, maps.spread(error, errors))
