"""Pages of scenes as one file to send: styles, scripts, pictures and numbers stand in it, and it refers to nothing else."""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from html import escape, unescape
from pathlib import Path

from raytruth.comparisons.execution.store import atomically
from raytruth.comparisons.results import Results
from raytruth.reference_tracer.errors import InputError

from .cases import scene_page
from .text.words import count, slug

KINDS = {".png": "image/png"}
PLANES = re.compile(r"""["']file["']: ["'](\.\./planes/[a-z0-9-]+\.js)["']""")
MAIN = re.compile(r'(<main id="content" tabindex="-1">)(.*)(?=</main>)', re.DOTALL)
NAMES = re.compile(r' (id|href|aria-describedby)="([^"]*)"')


def single_file(report: Path, results: Results, scenes: Sequence[str], path: Path) -> Path:
    """Writes the pages of `scenes` of `results`, from the folder of their `report`, into the file `path`. Raises InputError."""
    known = {scene.name: scene for scene in results.scenes}
    for name in scenes:
        if name not in known:
            raise InputError(f"the results have no scene {name!r}; choose one of {', '.join(known) or 'none'}")
    chosen = [known[name] for name in dict.fromkeys(scenes)]
    pages = {scene_page(scene): (report / scene_page(scene)).read_text(encoding="utf-8") for scene in chosen}
    # a page's own names have a word before them where there are several
    words = {Path(page).name: f"{slug(scene.name)}-" if len(chosen) > 1 else "" for page, scene in zip(pages, chosen)}
    mains = {page: MAIN.search(text)[2] for page, text in pages.items()}
    beside = lambda link: (report / "scenes" / unescape(link)).resolve()
    text = next(iter(pages.values()))
    scripts = list(dict.fromkeys(re.findall(r'<script src="([^"]+)" defer></script>', "".join(pages.values()))))
    # after what they work on, as deferred ones would run; the numbers before the viewer that may ask for them at once
    scripts[-1:-1] = dict.fromkeys(PLANES.findall("".join(mains.values())))
    inline = "".join(f"<script>\n{_text(beside(link), 'utf-16' if '/planes/' in link else 'utf-8')}</script>\n"
                     for link in scripts)
    text = re.sub(r'<script src="[^"]+" defer></script>\n?', "", text)
    text = re.sub(r'<link rel="stylesheet" href="([^"]+)">', lambda m: f"<style>\n{_text(beside(m[1]))}</style>", text)
    text = re.sub(r'<a ([^>]*?)href="(?!#)[^"]*"', r"<a \1", text)  # of the bar: the other pages are not there
    main = "".join(f'<section id="{words[Path(page).name]}content">{_renamed(content, Path(page).name, words)}</section>'
                   if len(chosen) > 1 else _renamed(content, Path(page).name, words) for page, content in mains.items())
    if len(chosen) > 1:
        text = re.sub(r"<title>.*?</title>", f"<title>{len(chosen)} scenes – raytruth report</title>", text, count=1)
        main = f'<section class="headline"><h1>{count(len(chosen), "scene")}</h1><ul class="jumps">' + "".join(
            f'<li><a href="#{word}content">{escape(scene.title or scene.name)}</a></li>'
            for word, scene in zip(words.values(), chosen)) + "</ul></section>" + main
    main = re.sub(r'<img src="([^"]+)"', lambda m: f'<img src="{data(beside(m[1]))}"', main)
    text = MAIN.sub(lambda m: m[1] + main, text).replace("</body>", f"{inline}</body>")
    with atomically(path) as part:
        part.write_text(text, encoding="utf-8", newline="\n")
    return path


def _renamed(text: str, page: str, words: dict[str, str]) -> str:
    """The content of `page` with its word before every name and link; links to pages that are not there lead nowhere."""
    def renamed(found: re.Match) -> str:
        kind, value = found.groups()
        if kind != "href":
            return f' {kind}="{words[page]}{value}"'
        to, _, anchor = value.partition("#")
        if to == "../index.html":
            return ' href="#content"'
        name = to or page
        return f' href="#{words[name]}{anchor or "content"}"' if name in words else ""

    return NAMES.sub(renamed, text)


def _text(path: Path, encoding: str = "utf-8") -> str:
    return path.read_text(encoding=encoding).replace("</script", "<\\/script")


def data(path: Path) -> str:
    return f"data:{KINDS[path.suffix]};base64,{base64.b64encode(path.read_bytes()).decode()}"
