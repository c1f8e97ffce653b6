"""Certifying one scene: picture, census, audit, paths."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from importlib.metadata import version

import numpy as np

from ..backend import backend, use_threads
from ..errors import InputError
from ..scene.model import Scene
from ..scene.promises import unproven
from ..tracer.camera_rays import camera_wave
from ..tracer.render import render
from ..tracer.wavefront import MOST_RAYS, trace
from ..tracer.world import World
from .audit import audit
from .census import Census
from .certificate import Certificate, Finding
from .objects import crossings_of
from .paths import CANDIDATES, candidates, compare_paths
from .reasons import SETTLED, reasons
from .records import KINDS, NOTHING
from .sample import edge_pixels

STAGES = {"picture": 0.05, "census": 0.45, "reasons": 0.05, "audit": 0.25, "paths": 0.2}  # shares of the work
Callback = Callable[[str, float], None]


def certify(scene: Scene, method: str = "exact", *, sample: int = 1000, paths: int = 16, threads: int | None = None,
            progress: Callback = lambda stage, share: None) -> Certificate:
    """Holds the picture of `scene` by `method` against proofs, exact decisions and high-precision paths.

    `sample` rays are decided by python-flint, `paths` pixels recomputed with 77 digits. `progress` is called with the
    name of the stage and the finished share of everything. Raises InputError for an unknown method.
    """
    if sample < 0 or paths < 0:
        raise InputError("the numbers of sampled rays and of paths must not be negative")
    start, arrays = time.perf_counter(), backend()
    use_threads(threads)
    stage = _stages(progress)
    picture = render(scene, method, threads=threads, progress=stage("picture"))
    edges = edge_pixels(picture.index, picture.color).ravel()
    pixels = candidates(picture, edges, CANDIDATES * paths)
    watched = np.zeros(len(edges), bool)
    watched[pixels] = True
    audited, proofs = World(scene, method, arrays), World(scene, "proof", arrays)
    census = Census(audited, proofs, edges, sample, watched)
    take(census, stage("census"))

    certificate = Certificate(scene.name, scene.hash, method, scene.camera.width, scene.camera.height,
                              scene.tracing.samples, census.kinds)
    certificate.unproven_bounds = unproven(scene)
    certificate.largest_gap, certificate.largest_radius = census.largest_gap, census.largest_radius
    report = _Report(scene)
    _tell_faults(report, census, audited, proofs)
    _tell_reasons(report, census, proofs)
    stage("reasons")(1.0)
    certificate.audit = audit(proofs, census.sample.draw(sample), report.blame, stage("audit"))
    certificate.paths = compare_paths(picture, pixels, paths, census, stage("paths"))
    certificate.findings, certificate.undecided = report.found(), report.reasons()
    certificate.seconds = time.perf_counter() - start
    certificate.versions = {name: version(name) for name in ("drjit", "python-flint", "numpy")}
    return certificate


def take(census: Census, progress: Callable[[float], None]) -> None:
    """Traces the whole picture under the census's eyes, in bands of bounded size."""
    world, scene = census.audited, census.audited.scene
    samples, count = scene.tracing.samples, scene.camera.width * scene.camera.height
    sides, band = world.camera_sides(), max(1, MOST_RAYS // samples**2)
    for first in range(0, count, band):
        census.first_pixel, size = first, min(band, count - first)
        trace(world, camera_wave(world, sides, first, size, samples), slots=max(size, 2), observe=census.observe)
        progress((first + size) / count)


def _stages(progress: Callback):
    """Progress of one stage as a share of everything."""
    def stage(name: str):
        names = list(STAGES)
        before = sum(STAGES[n] for n in names[:names.index(name)])
        return lambda share: progress(name, before + STAGES[name] * share)
    return stage


class _Report:
    """Collects faults and reasons, each with how often and one example."""

    def __init__(self, scene: Scene):
        self.scene, self.width = scene, scene.camera.width
        self.faults: Counter = Counter()
        self.unproven: Counter = Counter()
        self.examples: dict[tuple, str] = {}

    def blame(self, fault: str, row, index: int, text: str = "", count: int = 1) -> None:
        key = fault, KINDS[row["kind"]], self.name(index)
        self.faults[key] += count
        self.examples.setdefault(key, self.told(row) + (f"; {text}" if text else ""))

    def doubt(self, reason: str, row, index: int) -> None:
        key = reason, KINDS[row["kind"]], self.name(index)
        self.unproven[key] += 1
        self.examples.setdefault(key, self.told(row))

    def found(self) -> list[Finding]:
        return [Finding(*key, count, self.examples[key]) for key, count in self.faults.most_common()]

    def reasons(self) -> list[Finding]:
        return [Finding(*key, count, self.examples[key]) for key, count in self.unproven.most_common()]

    def name(self, index: int) -> str:
        if index == NOTHING:
            return "none"
        obj = self.scene.objects[index]
        return f"{obj.name or obj.surface.type} (object {index})"

    def told(self, row) -> str:
        y, x = divmod(int(row["pixel"]), self.width)
        numbers = lambda v: "(" + ", ".join(repr(float(c)) for c in v) + ")"
        a, p = row["audited"], row["proven"]
        if KINDS[row["kind"]] == "shadow":
            claims = f"light {a['light']:.9g}, proven {p['light']:.9g}"
        else:
            claims = f"{_hit(a)}, proven {_hit(p)} within {row['radius']:.1e}"
        return (f"pixel ({y}, {x}), generation {row['generation']}, from {numbers(row['o'])} "
                f"along {numbers(row['d'])}: {claims}")


def _hit(answer) -> str:
    return "nothing" if answer["index"] == NOTHING else f"object {answer['index']} at t = {answer['t']:.17g}"


def _tell_faults(report: _Report, census: Census, audited: World, proofs: World) -> None:
    for (fault, kind, index), count in census.wrong_counts.items():
        rows = np.concatenate(census.wrong[fault, kind, index])
        if fault != "wrong shadow":
            report.blame(fault, rows[0], index, count=count)
            continue
        differs = crossings_of(audited, rows)[0] != crossings_of(proofs, rows)[0]  # which object is it?
        blamed = np.where(differs.any(axis=0), differs.argmax(axis=0), NOTHING)
        for k in np.unique(blamed):
            own = np.flatnonzero(blamed == k)
            report.blame(fault, rows[own[0]], int(k), count=len(own))
        if count > len(rows):
            report.blame(fault, rows[0], NOTHING, "object not looked up", count - len(rows))


def _tell_reasons(report: _Report, census: Census, proofs: World) -> None:
    """The reason of every undecided ray; those that exact arithmetic settles are counted as such."""
    if not census.unproven:
        return
    rows = np.concatenate(census.unproven)
    for row, (reason, index) in zip(rows, reasons(proofs, rows, report.blame)):
        if reason == SETTLED:
            total = census.kinds[KINDS[row["kind"]]]
            total.settled, total.undecided = total.settled + 1, total.undecided - 1
        else:
            report.doubt(reason, row, index)
    for kind, total in census.kinds.items():
        more = total.undecided - sum(n for (_, k, _), n in report.unproven.items() if k == kind)
        if more:
            report.unproven["not looked into", kind, "none"] += more
            report.examples["not looked into", kind, "none"] = "only the first of many undecided rays are looked into"
