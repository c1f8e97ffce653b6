"""Check a finished picture of a scene against its truth, and name the mistake that it looks like.

examples:
  raytruth check-image mine.png figure-05-sphere
  raytruth check-image mine.exr my-scene.json -o errors.png    or a page: -o errors.html
  raytruth check-image mine.npy figure-17-scene1 --json

The picture (PNG, EXR, PFM, NPY or NPZ) is compared at its own size with both truths, exact intersections and the document's
method to the letter, linear colours, row 0 at the top. It passes if every pixel is as near as the file's numbers can say,
is acceptable if rounding explains the rest, and fails otherwise. Of a failure the classic mistakes are tried, alone and
together, until they show what the picture shows. The exit code is 0 for pass and acceptable, 1 for fail.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

from .. import memory
from ..arguments import require_file, sentence

BESIDE = 400  # bytes a pixel: the picture, a second truth, differences


def add_arguments(parser):
    parser.add_argument("file", metavar="FILE", type=Path, help="the picture: .png, .exr, .pfm, .npy or .npz")
    parser.add_argument("scene", help="name of a shipped scene or path of a scene file")
    parser.add_argument("-o", "--output", metavar="FILE", type=Path,
                        help="save a map of the errors (.png), or a page with all that was found (.html)")
    parser.add_argument("--no-cause", action="store_true", help="only the verdict")
    memory.add_argument(parser)
    parser.add_argument("--json", action="store_true", help="print the verdict as JSON")


def run(arguments) -> int:
    from raytruth.comparisons.ports.image_check import PLANES, check, sized
    from raytruth.comparisons.ports.picture import read
    from raytruth.comparisons.progress import Progress
    from raytruth.reference_tracer import llvm
    from raytruth.reference_tracer.scene.library import find

    llvm.narrow_kernels()  # each is for one picture or two
    require_file(arguments.output, ".png", ".html")
    scene, picture = find(arguments.scene), read(arguments.file)
    height, width, _ = picture.color.shape
    memory.require(sized(scene, width, height), PLANES, BESIDE, arguments.memory)
    with Progress(5, label=scene.name) as bar:
        checked, held = check(picture, scene, lambda what: bar.step(label=what), causes=not arguments.no_cause)
    if arguments.output and arguments.output.suffix == ".png":
        _map(held, arguments.output)
    elif arguments.output:
        _page(arguments, scene, checked, picture, held)
    if arguments.json:
        print(json.dumps({"file": str(arguments.file), "scene": scene.name, **checked.document()}))
    else:
        first, *lines = _lines(arguments, scene, checked)
        print("\n  ".join([first, *lines]))
        if checked.causes:
            heading = "likely cause:" if len(checked.causes) == 1 else f"likely causes, {len(checked.causes)} together:"
            print("\n    ".join([f"  {heading}", *_causes(checked)]))
    return 1 if checked.verdict == "fail" else 0


def _map(held, path: Path) -> None:
    import numpy as np

    from raytruth.reference_tracer.errors import InputError
    from raytruth.reference_tracer.tracer.image_files import write_8_bit
    from raytruth.reports.figures.scale import paint

    try:
        error = np.where(np.isfinite(held.error), held.error, np.nan)
        write_8_bit(paint(error, np.zeros_like(held.undecided), held.undecided & held.differing), path)
    except OSError as fault:
        raise InputError(f"{path}: cannot be written ({fault.strerror or fault})") from None


def _page(arguments, scene, checked, picture, held) -> None:
    import numpy as np

    from raytruth.reports import checked as page

    nothing = held.truth.index < 0
    page.write(arguments.output, f"{arguments.file.name} against {scene.name}: {checked.verdict}", checked.verdict != "fail",
               [*_lines(arguments, scene, checked)], [*_causes(checked)], (),
               [page.Beside(scene.name, held.wanted, picture.color, nothing, np.zeros_like(nothing),
                            held.undecided & held.differing)])


def _lines(arguments, scene, c) -> Iterator[str]:
    yield f"{sentence(arguments.file)}: {c.width} x {c.height}, held against {scene.name} {c.form}, {c.method}: {c.verdict}"
    yield from map(sentence, c.told)
    tried = (f"{form}, {method}: {count:,} of {c.pixels:,}" for form, method, count in c.tried)
    yield f"pixels that differ: {'; '.join(tried)}"
    if c.non_finite:
        yield f"{c.non_finite:,} of {c.pixels:,} pixels are NaN or infinite"
    if c.differing:
        yield (f"of {c.differing:,} that differ by more than the file's {c.tolerance:.3g}: {c.failing:,} fail, "
               f"{c.excused:,} are within what rounding may change, {c.undecided:,} are left open by the truth itself")
        w = c.worst
        show = lambda v: "(" + " ".join("not finite" if x is None else f"{x:.6g}" for x in v) + ")"
        yield (f"largest difference {'not finite' if w.size is None else f'{w.size:.4g}'} at row {w.row}, column {w.col}: "
               f"expected {show(w.expected)}, found {show(w.found)}")
    if c.note:
        yield c.note
    if c.where and not (c.causes and c.explained >= 0.99 * c.traced):
        yield f"failing pixels: {'; '.join(sentence(w) for w in c.where)}"


def _causes(c) -> Iterator[str]:
    for cause in c.causes:
        amount = "" if cause.amount is None else f", here {cause.amount:.4g}"
        where = f"section {cause.section}" + (f", decision {cause.decision}" if cause.decision else "")
        yield f"{cause.id}: {cause.sentence}{amount} ({where})"
    if c.causes:
        traced = "" if c.traced == c.failing else f", of which {c.traced:,} were traced"
        yield (f"explains {c.explained / c.traced:.1%} of the {c.failing:,} failing pixels{traced}; "
               f"{c.spoiled:,} of {c.beside:,} right ones would differ")
        if c.alternatives:
            yield f"this picture looks the same if {sentence('; or if '.join(c.alternatives))}"
