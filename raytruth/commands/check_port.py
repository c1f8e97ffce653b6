"""Ask another port of the document what it sees, and judge it case by case.

examples:
  raytruth check-port --list -- ./tracer                 what the port says it can, what will run, what will be skipped
  raytruth check-port -- ./tracer --serve                everything
  raytruth check-port --only surfaces/sphere -- python tracer.py
  raytruth check-port --only algorithm:scenes/figure-07-torus --history 12,30 -- ./tracer    the rays of one pixel
  raytruth check-port --known-failures known.json --junit out.xml --badge badge.json -- ./tracer
  raytruth check-port --image-only --level model -- node render.js

The port is a program that reads requests from its stdin and answers on its stdout: docs/ports/protocol.md. With
--image-only it is run once a scene, with a scene file and the file to write, and only its pictures are judged. It is a
stranger's program: it runs in a folder of its own, and its time, memory and output are limited, but it is no sandbox.

A case passes if every pixel keeps a limit that follows from the rays it hangs on; it is acceptable where some pixels show
what rounding may make of them; skipped cases count among all. The exit code is 1 if a case fails that --known-failures does
not list, or if one passes that it lists.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

from raytruth.reference_tracer.text import hanging

from ..arguments import number, require_file, require_folder, sentence

SHOWN = 12  # pictures on a page, those furthest off


def add_arguments(parser):
    parser.add_argument("port", nargs=argparse.REMAINDER, metavar="-- CMD ...", help="the port, with its arguments")
    parser.add_argument("--list", action="store_true", help="greet the port, show what would run and what not, and end")
    parser.add_argument("--only", action="append", metavar="CASE", default=[], help="a case, or all whose names begin so")
    parser.add_argument("--image-only", action="store_true", help="run the port as CMD SCENE PICTURE for every picture")
    parser.add_argument("--scenes", choices=("json", "text"), default="json", help="the scene files of --image-only")
    parser.add_argument("--pictures", choices=(".png", ".exr", ".pfm", ".npy"), default=".exr", help="those it writes")
    parser.add_argument("--level", choices=("algorithm", "model"), default="model", help="the truth of --image-only")
    parser.add_argument("--precision", type=int, choices=(64, 32), default=32, help="the numbers of --image-only")
    parser.add_argument("--seconds", type=number(0.1, 3600), default=60.0, help="that a case may take (default 60)")
    parser.add_argument("--history", metavar="ROW,COL|RAY", help="also show our rays of that pixel, beside the port's hit")
    parser.add_argument("--known-failures", metavar="FILE", type=Path, help="cases that may fail, and must")
    parser.add_argument("--write-known-failures", metavar="FILE.json", type=Path, help="list those that fail now")
    parser.add_argument("--junit", metavar="FILE.xml", type=Path, help="write JUnit XML")
    parser.add_argument("--html", metavar="FILE.html", type=Path, help="write a page with everything, and maps of the errors")
    parser.add_argument("--badge", metavar="FILE.json", type=Path, help="write a badge in the endpoint form of shields.io")
    parser.add_argument("-o", "--results", type=Path, metavar="DIR", default=Path("results"),
                        help="folder for check-port.json and kept truths (default results)")
    parser.add_argument("--json", action="store_true", help="print the document")


def run(arguments) -> int:
    from raytruth.comparisons import document as documents
    from raytruth.comparisons.ports import document
    from raytruth.comparisons.progress import Progress
    from raytruth.reference_tracer.errors import InputError

    command = arguments.port[1:] if arguments.port[:1] == ["--"] else arguments.port
    if not command:
        raise InputError("name the port's command after --, e.g. raytruth check-port -- ./tracer --serve")
    for path, suffix in ((arguments.junit, ".xml"), (arguments.badge, ".json"), (arguments.write_known_failures, ".json"),
                         (arguments.html, ".html")):
        require_file(path, suffix)
    require_folder(arguments.results)
    known = document.read_known(arguments.known_failures) if arguments.known_failures else frozenset()
    with Progress(1.0, quiet=arguments.list) as bar:
        found, failed, truths = _checked(arguments, command, known, bar)
    if arguments.list:
        return 0 if found.port else 1
    documents.write(found, arguments.results / "check-port.json")
    if arguments.junit:
        arguments.junit.write_bytes(document.junit(found))
    if arguments.badge:
        arguments.badge.write_text(json.dumps(document.badge(found)) + "\n")
    if arguments.html:
        _page(arguments, command, found, failed, truths)
    if arguments.write_known_failures:
        document.write_known(found, arguments.write_known_failures)
    if arguments.json:
        print(found.model_dump_json(indent=1))
    else:
        print(found.message or found.sentence)
        for cause in found.causes:
            print(f"it looks like this mistake: {_cause(cause)}")
        for id in found.mended:
            print(f"{id} is listed as failing, but passes: take it out of the list")
    return 0 if found.holds else 1


def _checked(arguments, command, known, bar):
    from raytruth.comparisons.ports import cases as all_cases
    from raytruth.comparisons.ports import check
    from raytruth.comparisons.ports.document import Check
    from raytruth.comparisons.ports.session import Failure
    from raytruth.comparisons.ports.truth import Truths
    from raytruth.comparisons.suites import head

    start, chosen, message = time.monotonic(), all_cases.chosen(arguments.only), ""
    results, causes, failed, truths = [], [], [], Truths(arguments.results)
    with _port(arguments, command) as port:
        if arguments.image_only:
            chosen = tuple(case for case in chosen if case.rays is None)
        declared = port.greet(min(arguments.seconds, 30))
        if not isinstance(declared, Failure):
            chosen = tuple(case for case in chosen if case.level in declared.levels)
        if isinstance(declared, Failure):
            message, declared = f"the port does not answer hello ({declared.verdict}): {declared.message}", None
        elif arguments.list:
            _list(declared, chosen)
        else:
            if not arguments.json:
                _introduce(declared)

            def told(result):
                bar.step(1 / len(chosen), result.id)
                if not arguments.json:
                    bar.log(_line(result, arguments, command))

            results = check.check(port, declared, chosen, truths, arguments.seconds, known, told, failed)
            bar.show("which mistakes show this")
            causes = check.likely(failed, declared.precision, truths)
            if arguments.history:
                bar.close()
                _history(port, declared, chosen, arguments)
    if message and arguments.list:
        print(message)
    return Check(**head(start), command=command, port=declared, message=message, results=results, causes=causes), failed, truths


def _port(arguments, command):
    from raytruth.comparisons.ports.protocol import PROTOCOL, SWITCHES, Declaration
    from raytruth.comparisons.ports.session import Painter, Port

    if not arguments.image_only:
        return Port(command)
    declared = Declaration(protocol=PROTOCOL, name=Path(command[0]).name[:100], scenes=arguments.scenes,
                           levels=(arguments.level,), precision=arguments.precision,
                           switches=SWITCHES)
    return Painter(command, declared, arguments.pictures)


def _introduce(declared) -> None:
    name = f"{declared.name} {declared.version}".strip()
    print(sentence(f"{name}: {' and '.join(declared.levels)}, fp{declared.precision}, surfaces "
                   f"{', '.join(declared.surfaces)}; switches {', '.join(declared.switches) or 'none'}"))


def _list(declared, chosen) -> None:
    _introduce(declared)
    skipped = 0
    for case in chosen:
        why = case.lacks(declared)
        skipped += why is not None
        print(hanging(f"{'skip' if why else 'run':<5} {case.id:<52}", why or ""))
    print("cases of truths that the port does not claim are no cases of its own")
    print(f"{len(chosen) - skipped} of {len(chosen)} cases will run, {skipped} will be skipped")


def _cause(cause) -> str:
    return f"{cause.sentence} ({cause.id}; {cause.share:.0%} of what differs hangs on it)"


def _page(arguments, command, found, failed, truths) -> None:
    import numpy as np

    from raytruth.reference_tracer.tracer.film import UNDECIDED
    from raytruth.reports import checked

    def beside(case, reply):
        truth = truths.planes(case)
        index = reply.arrays.get("index", truth["index"])
        return checked.Beside(case.id, truth["color"], reply.arrays["color"], (truth["index"] < 0) & (index < 0),
                              truth["index"] != index, truth["status"] == UNDECIDED)

    def error(case, reply):  # what is not finite is furthest off
        return np.nan_to_num(np.abs(reply.arrays["color"] - truths.planes(case)["color"]), nan=np.inf).mean()

    pictures = sorted((f for f in failed if f.case.rays is None), key=lambda f: -error(f.case, f.reply))
    rows = [checked.Row(r.verdict, (r.id, *filter(None, [sentence(r.message), *_details(r, arguments, command)])))
            for r in found.results]
    checked.write(arguments.html, f"{found.port.name if found.port else command[0]} against raytruth", found.holds,
                  [found.message or found.sentence], [*map(_cause, found.causes)], rows,
                  [beside(f.case, f.reply) for f in pictures[:SHOWN]])


def _line(result, arguments, command) -> str:
    known = " (as listed)" if result.known else ""
    first = hanging(f"{result.verdict + known:<11} {result.id:<52}", sentence(result.message), indent=12)
    return "\n            ".join([first, *_details(result, arguments, command)])


def _details(result, arguments, command) -> list[str]:
    lines = []
    if result.where:
        numbers = lambda values: ", ".join(f"{v:.10g}" for v in values)
        bound = f", bound {result.bound:.2g}" if result.bound is not None else ""
        lines.append(f"{result.plane or 'color'} at {result.where.text}: expected {numbers(result.expected)}, "
                     f"got {numbers(result.got)}{bound}")
    if result.verdict == "fail":
        import shlex

        place = f"{result.where.row},{result.where.col}" if result.where.row is not None else str(result.where.ray)
        lines.append(f"repeat: raytruth check-port --only {result.id} --history {place} -- {shlex.join(command)}")
    return lines


def _history(port, declared, chosen, arguments) -> None:
    """Our rays of one pixel or given ray, and what the port says of the first."""
    from raytruth.comparisons.ports import history
    from raytruth.reference_tracer.errors import InputError

    if len(chosen) != 1 and len({case.name for case in chosen}) != 1:
        raise InputError("--history: name one case by --only")
    case = next((c for c in chosen if c.level in declared.levels), None)
    if case is None:
        raise InputError("--history: the port does not claim this case")
    for line in history.beside(port, case, arguments.history, arguments.seconds):
        print(line, file=sys.stdout)
