"""The mark file of a report: that the folder is ours to replace, and what the report in it was made from."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from comparisons import results as comparison
from comparisons.execution.machine import packages, source_hash
from comparisons.results import Results

from .documents import READERS

MARK = ".raytruth-report"  # a file in every report: a folder without it is not ours to replace


def fingerprint(results: Results, folder: Path) -> str:
    """A hash of all that can change a report: the documents, the sizes of the planes, all code, the packages.

    Names of planes are hashes of what can change them, so that their contents need not be read.
    """
    digest = hashlib.sha256(json.dumps([packages(), source_hash()], sort_keys=True).encode())
    here = Path(__file__).parent
    for file in sorted(p for p in here.rglob("*") if p.is_file() and "__pycache__" not in p.parts):
        digest.update(f"{file.relative_to(here).as_posix()} {file.stat().st_size}\n".encode() + file.read_bytes())
    for name in (comparison.FILE, *READERS):
        path = folder / name
        content = path.read_bytes() if path.is_file() else b""
        digest.update(f"{name} {path.is_file()} {len(content)}\n".encode() + content)
    for run in results.runs:
        if run.planes is not None:
            path = folder / run.planes
            digest.update(f"{run.planes} {path.stat().st_size if path.is_file() else None}\n".encode())
    return digest.hexdigest()


def write(report: Path, made_from: str) -> None:
    """Marks the complete report in the folder `report`."""
    (report / MARK).write_text(f"{made_from}\n{_listing(report)}\n", encoding="utf-8", newline="\n")


def is_current(report: Path, made_from: str) -> bool:
    """Whether `report` holds a report made from exactly that, with no file lost, added or of another size."""
    try:
        return (report / MARK).read_text(encoding="utf-8") == f"{made_from}\n{_listing(report)}\n"
    except (OSError, ValueError):
        return False


def _listing(report: Path) -> str:
    """A hash of the names and sizes of all files but the mark."""
    files = sorted(p for p in report.rglob("*") if p.is_file() and p.name != MARK)
    lines = (f"{p.relative_to(report).as_posix()} {p.stat().st_size}\n" for p in files)
    return hashlib.sha256("".join(lines).encode("utf-8", "surrogatepass")).hexdigest()
