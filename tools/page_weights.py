"""What a report asks of a reader's machine: bytes and seconds of each page, of the first look at its numbers, of the whole.

  python -m tools.page_weights reports/html

A page weighs what the browser has loaded when it has scrolled to its end, without planes. The exit code is 1 where a page or
the whole is heavier than MOST_BYTES; seconds are told and decide nothing, for they hang on what else the machine does.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from urllib.parse import unquote, urlsplit

from raytruth.arguments import Parser
from raytruth.reference_tracer.errors import InputError

from . import screenshots

MOST_BYTES = {"another page": 2e6, "a scene page": 1e6, "the report": 120e6}
READY = "#viewer[data-ready]"


def measured(report: Path, browser) -> list[tuple[str, str, float, float, float | None]]:
    """Of every page: its kind, its name, its bytes, the seconds until it is loaded, those of the first flip, if it has one."""
    found = []
    for path in sorted(report.rglob("*.html")):
        page, files = browser.new_page(viewport={"width": 1400, "height": 900}), set()
        page.on("request", lambda request, files=files: files.add(Path(unquote(urlsplit(request.url).path)))
                if request.url.startswith("file:") else None)
        start = time.perf_counter()
        page.goto(path.resolve().as_uri(), wait_until="load")
        loaded = time.perf_counter() - start
        page.evaluate(screenshots.SCROLLED)
        page.wait_for_load_state("networkidle")
        size, flipped = sum(file.stat().st_size for file in files if file.is_file()), None
        if page.query_selector("[data-part=open]"):
            start = time.perf_counter()
            page.click("[data-part=open]")
            page.wait_for_selector(READY)
            page.click("[data-part=flip]")
            flipped = time.perf_counter() - start
        kind = "a scene page" if path.parent.name == "scenes" else "another page"
        found.append((kind, path.relative_to(report).as_posix(), size, loaded, flipped))
        page.close()
    return found


def main(arguments: list[str] | None = None) -> int:
    from playwright.sync_api import sync_playwright

    parser = Parser(prog="python -m tools.page_weights", description="Bytes and seconds of the pages of a report.")
    parser.add_argument("report", type=Path, help="the folder of a report, e.g. reports/html")
    report = parser.parse_args(arguments).report
    try:
        program = screenshots.browser_for(report)
    except InputError as error:
        print(f"tools.page_weights: {error}", file=sys.stderr)
        return 2
    with sync_playwright() as playwright, playwright.chromium.launch(executable_path=program, args=["--no-sandbox"]) as browser:
        found = measured(report, browser)
    for _, name, size, loaded, flipped in found:
        flips = f", flips after {flipped:.2f} s" if flipped else ""
        print(f"{name:<44} {size / 1e6:>6.2f} MB  loaded in {loaded:.2f} s{flips}")
    whole = sum(file.stat().st_size for file in report.rglob("*") if file.is_file())
    print(f"{'the report':<44} {whole / 1e6:>6.1f} MB")
    heavy = [name for kind, name, size, *_ in [*found, ("the report", "the report", whole)] if size > MOST_BYTES[kind]]
    print(f"too heavy: {', '.join(heavy)}" if heavy else "nothing is too heavy")
    return 1 if heavy else 0


if __name__ == "__main__":
    sys.exit(main())
