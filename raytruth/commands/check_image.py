"""Check a finished picture of a scene against its truth, and name the mistake that it looks like.

examples:
  raytruth check-image mine.png figure-05-sphere
  raytruth check-image mine.exr my-scene.json -o errors.png
  raytruth check-image mine.npy figure-17-scene1 --json

The picture (PNG, EXR, PFM, NPY or NPZ) is compared at its own size with both truths, exact intersections and the document's
method to the letter, linear colours, row 0 at the top. It passes if every pixel is as near as the file's numbers can say,
is acceptable if rounding explains the rest, and fails otherwise. Of a failure the classic mistakes are tried, alone and
together, until they show what the picture shows. The exit code is 0 for pass and acceptable, 1 for fail.
"""

from __future__ import annotations

import json
from pathlib import Path

from .. import memory
from ..arguments import require_file, sentence

BESIDE = 400  # bytes a pixel: the picture, a second truth, differences


def add_arguments(parser):
    parser.add_argument("file", metavar="FILE", type=Path, help="the picture: .png, .exr, .pfm, .npy or .npz")
    parser.add_argument("scene", help="name of a shipped scene or path of a scene file")
    parser.add_argument("-o", "--output", metavar="FILE.png", type=Path, help="save a map of the errors")
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
    require_file(arguments.output, ".png")
    scene, picture = find(arguments.scene), read(arguments.file)
    height, width, _ = picture.color.shape
    memory.require(sized(scene, width, height), PLANES, BESIDE, arguments.memory)
    with Progress(5, label=scene.name) as bar:
        checked, error, undecided = check(picture, scene, lambda what: bar.step(label=what), causes=not arguments.no_cause)
    if arguments.output:
        _map(error, undecided, arguments.output)
    if arguments.json:
        print(json.dumps({"file": str(arguments.file), "scene": scene.name, **checked.document()}))
    else:
        _tell(arguments, scene, checked)
    return 1 if checked.verdict == "fail" else 0


def _map(error, undecided, path: Path) -> None:
    import numpy as np

    from raytruth.reference_tracer.errors import InputError
    from raytruth.reference_tracer.tracer.image_files import write_8_bit
    from raytruth.reports.figures.scale import paint

    try:
        write_8_bit(paint(error, np.zeros_like(undecided), undecided), path)
    except OSError as fault:
        raise InputError(f"{path}: cannot be written ({fault.strerror or fault})") from None


def _tell(arguments, scene, c) -> None:
    print(f"{sentence(arguments.file)}: {c.width} x {c.height}, held against {scene.name} {c.form}, {c.method}: {c.verdict}")
    for line in c.told:
        print(f"  {sentence(line)}")
    tried = (f"{form}, {method}: {count:,} of {c.pixels:,}" for form, method, count in c.tried)
    print(f"  pixels that differ: {'; '.join(tried)}")
    if c.non_finite:
        print(f"  {c.non_finite:,} of {c.pixels:,} pixels are NaN or infinite")
    if c.differing:
        print(f"  of {c.differing:,} that differ by more than the file's {c.tolerance:.3g}: {c.failing:,} fail, "
              f"{c.excused:,} are within what rounding may change, {c.undecided:,} are left open by the truth itself")
        w = c.worst
        show = lambda v: "(" + " ".join("not finite" if x is None else f"{x:.6g}" for x in v) + ")"
        print(f"  largest difference {'not finite' if w.size is None else f'{w.size:.4g}'} at row {w.row}, column {w.col}: "
              f"expected {show(w.expected)}, found {show(w.found)}")
    if c.verdict != "fail":
        return
    if c.causes:
        print("  likely cause:" if len(c.causes) == 1 else f"  likely causes, {len(c.causes)} together:")
        for cause in c.causes:
            amount = "" if cause.amount is None else f", here {cause.amount:.4g}"
            where = f"section {cause.section}" + (f", decision {cause.decision}" if cause.decision else "")
            print(f"    {cause.id}: {cause.sentence}{amount} ({where})")
        traced = "" if c.traced == c.failing else f", of which {c.traced:,} were traced"
        print(f"    explains {c.explained / c.traced:.1%} of the {c.failing:,} failing pixels{traced}; "
              f"{c.spoiled:,} of {c.beside:,} right ones would differ")
        if c.alternatives:
            print(f"    this picture looks the same if {sentence('; or if '.join(c.alternatives))}")
    if c.note:
        print(f"  {c.note}")
    if c.where and not (c.causes and c.explained >= 0.99 * c.traced):
        print(f"  failing pixels: {'; '.join(sentence(w) for w in c.where)}")
