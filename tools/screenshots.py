"""Pictures of a report in a real browser: each kind of page, light and dark, wide and narrow, to be looked at.

  python -m tools.screenshots reports/html -o results/screenshots

The browser is the system's Chromium, driven by Playwright. The exit code is 1 where a page says something on the console,
asks the network for anything, or is wider than its window; it says so.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from raytruth.arguments import Parser, require_folder
from raytruth.reference_tracer.errors import InputError

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
WINDOWS = ((1400, 900), (360, 740))
SCHEMES = ("light", "dark")
# pages leave out what nobody has scrolled to, until then
SCROLLED = """async () => { for (let y = 0; y < document.body.scrollHeight; y += 800) {
    window.scrollTo(0, y); await new Promise(done => setTimeout(done, 20)); }
    window.scrollTo(0, 0); }"""
WHOLE = "* { content-visibility: visible !important; }"


def kinds(report: Path) -> list[str]:
    """A page of each kind, relative to the folder: those at its top, and the first of every folder."""
    pages = sorted(path.relative_to(report).as_posix() for path in report.rglob("*.html"))
    first = {}
    for page in pages:
        first.setdefault(page if "/" not in page else page.rpartition("/")[0], page)
    return sorted(first.values(), key=lambda page: (page != "index.html", page))


def photographed(report: Path, folder: Path, browser) -> list[str]:
    """Writes the pictures into `folder`; what is wrong with the pages, a sentence each. `browser` is Playwright's."""
    wrong = []
    for width, height in WINDOWS:
        for scheme in SCHEMES:
            page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
            said: list[str] = []
            page.on("console", lambda message, said=said: said.append(f"says {message.text!r}"))
            page.on("pageerror", lambda error, said=said: said.append(f"fails: {error}"))
            page.on("request", lambda request, said=said: said.append(f"asks for {request.url}")
                    if not request.url.startswith(("file:", "data:", "blob:")) else None)
            for name in kinds(report):
                said.clear()
                page.goto((report / name).resolve().as_uri())
                excess = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
                if excess > 0:
                    said.append(f"is {excess} pixels wider than its window")
                page.add_style_tag(content=WHOLE)
                page.evaluate(SCROLLED)
                shown = folder / f"{name.removesuffix('.html').replace('/', '-')}-{width}-{scheme}.png"
                page.screenshot(path=shown, full_page=True)
                wrong += [f"{name} at {width}, {scheme}: {what}" for what in said]
            page.close()
    return wrong


def browser_for(report: Path) -> str:
    """The path of a Chromium. Raises InputError where there is none, or no report."""
    if not (report / "index.html").is_file():
        raise InputError(f"{report}: holds no report; 'raytruth report' makes one")
    if (program := next(filter(None, map(shutil.which, BROWSERS)), None)) is None:
        raise InputError("no Chromium on this machine: install the package chromium")
    return program


def main(arguments: list[str] | None = None) -> int:
    from playwright.sync_api import sync_playwright

    parser = Parser(prog="python -m tools.screenshots", description="Pictures of each kind of page of a report.")
    parser.add_argument("report", type=Path, help="the folder of a report, e.g. reports/html")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the pictures")
    chosen = parser.parse_args(arguments)
    try:
        require_folder(chosen.output)
        program = browser_for(chosen.report)
    except InputError as error:
        print(f"tools.screenshots: {error}", file=sys.stderr)
        return 2
    chosen.output.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright, playwright.chromium.launch(executable_path=program, args=["--no-sandbox"]) as browser:
        wrong = photographed(chosen.report, chosen.output, browser)
    count = len(list(chosen.output.glob("*.png")))
    print("\n".join(wrong) or f"{count} pictures in {chosen.output}: nothing is wrong with them that a program can see")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
