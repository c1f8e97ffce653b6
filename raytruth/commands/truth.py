"""Write the ground truth as a bundle of files that need nothing of raytruth.

examples:
  raytruth truth -o truth          the folder truth and the file truth.zip
  cd truth && sha256sum -c manifest-sha256.txt
  raytruth truth --files           the names of all its files

Test vectors (single rays, whole events, small pictures), every shipped scene with all planes under both truths, and the
specification that one can write a port from. The layout is that of BagIt (RFC 8493).
"""

from __future__ import annotations

import json
from pathlib import Path

from ..arguments import require_folder


def add_arguments(parser):
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, help="the folder to write, new or empty")
    parser.add_argument("--files", action="store_true", help="print the names of the files and end")
    parser.add_argument("--results", type=Path, metavar="DIR", default=Path("results"),
                        help="folder in which truths are kept (default results)")
    parser.add_argument("--json", action="store_true", help="print what was written as JSON")


def run(arguments) -> int:
    from raytruth.comparisons.ports import bundle
    from raytruth.comparisons.ports.truth import Truths
    from raytruth.comparisons.progress import Progress
    from raytruth.reference_tracer.errors import InputError

    if arguments.files:
        print("\n".join(f"data/{name}" for name in bundle.files()))
        return 0
    if arguments.output is None:
        raise InputError("-o: name the folder to write, e.g. raytruth truth -o truth")
    require_folder(arguments.output)
    with Progress(1.0, label="truth") as bar:
        archive = bundle.write(arguments.output, Truths(arguments.results), lambda label, share: bar.to(share, label))
    size = sum(path.stat().st_size for path in arguments.output.rglob("*") if path.is_file())
    packed, count = archive.stat().st_size, len(bundle.files())
    told = {"folder": str(arguments.output), "archive": str(archive), "files": count, "bytes": size, "archive bytes": packed}
    text = f"{count} files, {size / 1e6:.1f} MB in {arguments.output}, {packed / 1e6:.1f} MB in {archive}"
    print(json.dumps(told) if arguments.json else text)
    return 0
