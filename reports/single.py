"""One scene's page as one file to send: styles, scripts, pictures and numbers stand in it, and it refers to nothing else."""

from __future__ import annotations

import base64
import re
from html import unescape
from pathlib import Path

from raytruth.comparisons.execution.store import atomically
from raytruth.comparisons.results import Results
from raytruth.reference_tracer.errors import InputError

from .cases import scene_page

KINDS = {".png": "image/png"}
PLANES = re.compile(r"""["']file["']: ["'](\.\./planes/[a-z0-9-]+\.js)["']""")


def single_file(report: Path, results: Results, scene: str, path: Path) -> Path:
    """Writes the page of `scene` of `results`, from the folder of their `report`, into the file `path`. Raises InputError."""
    pages = {s.name: scene_page(s) for s in results.scenes}
    if scene not in pages:
        raise InputError(f"the results have no scene {scene!r}; choose one of {', '.join(pages) or 'none'}")
    page = report / pages[scene]
    text = page.read_text(encoding="utf-8")
    beside = lambda link: (page.parent / unescape(link)).resolve()
    text = re.sub(r'<link rel="stylesheet" href="([^"]+)">', lambda m: f"<style>\n{_text(beside(m[1]))}</style>", text)
    scripts = re.findall(r'<script src="([^"]+)" defer></script>', text)
    text = re.sub(r'<script src="[^"]+" defer></script>\n?', "", text)
    # after what they work on, as deferred ones would run; the numbers before the viewer that may ask for them at once
    scripts[-1:-1] = PLANES.findall(text)
    inline = "".join(f"<script>\n{_text(beside(link), 'utf-16' if '/planes/' in link else 'utf-8')}</script>\n"
                     for link in scripts)
    text = text.replace("</body>", f"{inline}</body>")
    text = re.sub(r'<img src="([^"]+)"', lambda m: f'<img src="{_data(beside(m[1]))}"', text)
    text = re.sub(r'<a ([^>]*?)href="(?!#)[^"]*"', r"<a \1", text)  # the other pages are not there
    with atomically(path) as part:
        part.write_text(text, encoding="utf-8", newline="\n")
    return path


def _text(path: Path, encoding: str = "utf-8") -> str:
    return path.read_text(encoding=encoding).replace("</script", "<\\/script")


def _data(path: Path) -> str:
    return f"data:{KINDS[path.suffix]};base64,{base64.b64encode(path.read_bytes()).decode()}"
