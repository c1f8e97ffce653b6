"""Build the HTML report of the results: opens from disk, needs no network.

example:
  raytruth compare && raytruth report      then open reports/html/index.html
"""

from __future__ import annotations

from pathlib import Path


def add_arguments(parser):
    parser.add_argument("--results", metavar="DIR", type=Path, default=Path("results"), help="default: results")
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, default=Path("reports/html"),
                        help="default: reports/html")


def run(arguments) -> int:
    import reports

    print(reports.build(arguments.results, arguments.output))
    return 0
