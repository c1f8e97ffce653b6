"""Hold a picture against proofs, exact decisions and high-precision paths.

examples:
  raytruth certify figure-07-torus --size 160x120
  raytruth certify                                        every shipped scene
  raytruth certify my-scene.json --method interval --sample 5000 --paths 50
  raytruth certify figure-09-heart --method paper         how often does the document's own method fail?

Every ray of the picture (camera, reflection, refraction and shadow rays) is decided once more by outward-rounded
interval arithmetic: a proof. python-flint decides a sample of them exactly, tangency included, half of it at
silhouettes and shadow edges. A few whole pixels are recomputed with 77 digits. The exit code is 1 if anything
contradicts.
"""

from __future__ import annotations

import json

from ..arguments import resized, size, whole


def add_arguments(parser):
    parser.add_argument("scene", nargs="*", help="names of shipped scenes or paths of files (default: all shipped)")
    parser.add_argument("--size", metavar="WxH", type=size, help="picture size instead of the scene's")
    parser.add_argument("--method", default="exact", help="the first-hit method to certify (default exact)")
    parser.add_argument("--sample", type=whole(0), default=1000, metavar="N", help="rays to decide exactly (default 1000)")
    parser.add_argument("--paths", type=whole(0), default=16, metavar="N", help="pixels to recompute (default 16)")
    parser.add_argument("--threads", type=whole(1, 1024), metavar="N", help="threads to use (default: all cores)")
    parser.add_argument("--json", action="store_true", help="print a JSON list for programs")


def run(arguments) -> int:
    from comparisons.progress import Progress
    from reference_tracer.certify import certify
    from reference_tracer.certify.text import told
    from reference_tracer.scene import library

    scenes = [library.find(name) for name in arguments.scene or library.names()]
    scenes = [resized(scene, arguments.size) for scene in scenes]
    certificates, bar = [], Progress(len(scenes))
    for k, scene in enumerate(scenes):
        def show(stage: str, share: float, done=k, name=scene.name):
            bar.label = f"{name}: {stage}"
            bar.to(done + share)
        c = certify(scene, arguments.method, sample=arguments.sample, paths=arguments.paths, threads=arguments.threads,
                    progress=show)
        certificates.append(c)
        if not arguments.json:
            bar.close()
            print(told(c), end="\n\n", flush=True)
    bar.close()
    if arguments.json:
        print(json.dumps([c.document() for c in certificates], indent=1))
    elif len(certificates) > 1:
        print(_summary(certificates))
    return 0 if all(c.passed for c in certificates) else 1


def _summary(certificates) -> str:
    total = lambda pick: sum(pick(c) for c in certificates)
    rays, undecided = total(lambda c: c.rays), total(lambda c: c.undecided_rays)
    wrong = total(lambda c: sum(k.wrong for k in c.kinds.values()))
    return (f"{len(certificates)} scenes, {total(lambda c: c.passed)} hold: {rays:,} rays, "
            f"{wrong} wrong, {undecided / max(rays, 1):.1e} undecided; "
            f"{total(lambda c: c.audit.rays):,} audited, {total(lambda c: c.audit.contradictions)} contradictions; "
            f"{total(lambda c: c.paths.paths)} paths, largest error "
            f"{max((c.paths.largest_error for c in certificates), default=0.0):.1e}, "
            f"{total(lambda c: len(c.paths.near_critical))} near-critical")
