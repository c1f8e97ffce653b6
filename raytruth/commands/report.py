"""Build the HTML report of the results: opens from disk, needs no network.

examples:
  raytruth compare && raytruth report                     then open reports/html/index.html
  raytruth report --against earlier-results               says what is better, worse, slower, new and gone
  raytruth report --profile                               where the time of the suites went when they last ran
  raytruth report --scene figure-09-heart --single-file heart.html    pages of scenes as one file to send
"""

from __future__ import annotations

from pathlib import Path


def add_arguments(parser):
    parser.add_argument("--results", metavar="DIR", type=Path, default=Path("results"), help="default: results")
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, default=Path("reports/html"),
                        help="default: reports/html")
    parser.add_argument("--against", metavar="DIR", type=Path, help="results of an earlier run, to tell changes against")
    parser.add_argument("--profile", action="store_true", help="say where the time of the last runs went, and build nothing")
    parser.add_argument("--scene", metavar="SCENE", action="append", default=[], help="a scene of --single-file (repeatable)")
    parser.add_argument("--single-file", metavar="FILE", type=Path,
                        help="writes the pages of these scenes, pictures and numbers included, into this file as well")


def run(arguments) -> int:
    from raytruth.comparisons import times
    from raytruth.reference_tracer.errors import InputError

    if (arguments.single_file is None) == bool(arguments.scene):
        raise InputError("--single-file and --scene belong together: name the file, and the scenes that it shows")
    if arguments.profile:
        print("\n".join(times.told(arguments.results)))
        return 0
    from raytruth import reports
    from raytruth.comparisons import results

    index = reports.build(arguments.results, arguments.output, against=arguments.against)
    if arguments.single_file is None:
        print(index)
        return 0
    from raytruth.reports.single import single_file

    print(single_file(index.parent, results.read(arguments.results), arguments.scene, arguments.single_file))
    return 0
