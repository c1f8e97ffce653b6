"""The templates' environment: every text is escaped, every name must exist."""

from __future__ import annotations

from jinja2 import Environment, PackageLoader, StrictUndefined

from . import scale
from .cases import is_lower_bound, scene_page
from .decisions import pieces
from .names import slug
from .numbers import parts
from .pages.page import Page
from .report import Report
from .words import KEY_METRICS, STATES, VERDICTS, capital, metric, sentence

STATIC = ("report.css", "report.js")


def environment() -> Environment:
    templates = Environment(loader=PackageLoader("reports"), autoescape=True, undefined=StrictUndefined,
                            trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True)
    templates.filters.update(parts=parts, metric=metric, sentence=sentence, capital=capital, slug=slug, pieces=pieces, page_of=scene_page)
    templates.tests.update(lower_bound=is_lower_bound)
    templates.globals.update(scale=scale, VERDICTS=VERDICTS, STATES=STATES, KEY_METRICS=KEY_METRICS)
    return templates


def rendered(templates: Environment, page: Page, report: Report, pages: list[Page]) -> str:
    """`page` as HTML; `pages` are those its bar may lead to."""
    return templates.get_template(page.template).render(
        report=report, root=page.root, path=page.path, bar=[p for p in pages if p.nav], **page.content)


def static(templates: Environment) -> dict[str, str]:
    """The files that are copied as they are: name to text."""
    return {name: templates.loader.get_source(templates, name)[0] for name in STATIC}
