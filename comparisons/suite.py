"""The comparison suite: which renderers meet on which scenes, and what is measured."""

from __future__ import annotations

import datetime
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from pathlib import Path

from reference_tracer.scene.model import Scene

from . import document, effects, studies
from .agreement import matrix, records, tightness
from .attribution.explain import LARGEST, explained
from .execution.machine import machine
from .execution.pool import Pool, Progress, Silent
from .execution.store import require_folder
from .results import COMMAND, FILE, Comparison, Results, Run, SceneRecord, Verdict
from .runs import Request, RunStore
from .verdicts.judge import excuses, judge, largest_difference, tolerance_of
from .verdicts.pairs import Measurements, Pair

TRUTH = "exact"
# on demand: mitsuba-sdfgrid and povray-isosurface take minutes for some scenes; mitsuba-refined has the surfaces from f
COMPARED = ("paper", "mitsuba-native", "mitsuba-mesh", "embree", "povray")
MOST_SAMPLES = 16  # a pixel, of a square picture as wide as allowed; a scene of more is compared at a smaller size
SECONDS_PER_RUN = 300.0


@dataclass(frozen=True)
class Options:
    """How a suite is run."""

    folder: Path
    renderers: tuple[str, ...] = COMPARED
    largest: int = 640  # pixels of the longer side; larger scenes are compared at this size, those of many samples smaller
    limit: float = SECONDS_PER_RUN
    jobs: int = 2  # cases made at the same time
    with_studies: bool = True
    progress: Progress = field(default_factory=Silent)


def compare(scenes: Sequence[Scene], options: Options) -> Results:
    """Runs every renderer on every scene, compares each picture with the truth and with every other one, and writes
    results.json and matrix.json.

    A run that fails costs only its own comparisons. Finished runs and comparisons are kept by content in the folder:
    an interrupted suite goes on where it stopped.
    """
    start = time.monotonic()
    require_folder(options.folder)
    scenes = [_fitted(scene, options.largest) for scene in scenes]
    store, names = RunStore(options.folder), (TRUTH, *options.renderers)
    planned = studies.planned(scenes) if options.with_studies else []
    requests = [Request(scene, name) for name in names for scene in scenes]
    requests += [request for study in planned for request in study.requests()]
    requests += effects.requests(scenes) + tightness.requests(scenes, options.renderers) if options.with_studies else []
    with Pool(options.jobs, options.progress) as pool:
        runs = store.make_all(requests, pool, options.limit)
        measurements = Measurements(options.folder, pool, options.limit)
        pairs = [Pair(scene, first, second) for scene in scenes
                 for first, second in combinations([runs[Request(scene, name).key] for name in names], 2)
                 if first.state == second.state == "ok"]
        more = [pair for study in planned for pair in study.pairs(runs)]
        more += effects.pairs(scenes, runs) + tightness.pairs(scenes, options.renderers, runs) if options.with_studies else []
        measurements.make([*pairs, *more])
        comparisons = [_compared(scene, runs[Request(scene, TRUTH).key], runs[Request(scene, name).key], measurements)
                       for scene in scenes for name in options.renderers]
        comparisons = explained(comparisons, [_fitted(scene, LARGEST) for scene in scenes], runs, options.folder, pool)
        rows = tightness.tightness(scenes, options.renderers, runs, measurements) if options.with_studies else []
        found = matrix.matrix(scenes, names, runs, pairs, measurements, rows)
        series = [study.series(runs, measurements) for study in planned]
        shown = effects.effects(scenes, runs, measurements) if options.with_studies else []
    records.write(found, options.folder)
    results = Results(created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
                      seconds=round(time.monotonic() - start, 1), machine=machine(),
                      scenes=[_scene_record(s) for s in scenes], runs=list(runs.values()), comparisons=comparisons,
                      series=series, effects=shown)
    return document.keep(results, options.folder / FILE, COMMAND)


def _fitted(scene: Scene, largest: int) -> Scene:
    width, height, samples = scene.camera.width, scene.camera.height, scene.tracing.samples
    scale = min(largest / max(width, height), (MOST_SAMPLES * largest**2 / (width * height * samples**2)) ** 0.5)
    return scene if scale >= 1 else scene.resized(max(1, round(width * scale)), max(1, round(height * scale)))


def _compared(scene: Scene, truth: Run, test: Run, measurements: Measurements) -> Comparison:
    about = {"id": f"{scene.name}--{test.renderer}", "scene": scene.name, "reference": truth.key, "test": test.key,
             "against": "model",
             "command": f"raytruth compare {scene.name} --renderers {test.renderer} --largest "
                        f"{max(scene.camera.width, scene.camera.height)}"}
    for run in (truth, test):
        if run.state != "ok":
            return Comparison(**about, verdict="not compared", reason=f"{run.title} {run.state}: {run.message}")
    found = measurements.of(Pair(scene, truth, test))
    if found.state != "ok":
        return Comparison(**about, verdict="not compared", reason=f"measuring {found.state}: {found.message}")
    measured = found.metrics
    if test.renderer == "paper":
        verdict, reason, gates = *_of_the_literal_method(measured, scene), []
    else:
        limit = largest_difference(test)
        verdict, reason, gates = judge(measured, tolerance_of(test), excuses(measured, limit) if limit else ())
    return Comparison(**about, verdict=verdict, reason=reason, gates=gates, metrics=measured, worst=found.worst)


def _of_the_literal_method(measured: dict, scene: Scene) -> tuple[Verdict, str]:
    """The literal method is the algorithm's truth; where it leaves the model's, that is its nature, not a fault."""
    wrong, failing = measured["object mismatches"], measured["failing pixels"]
    if not wrong and not failing:
        return "agrees", f"at step size {scene.tracing.step_size:g} the literal method misses nothing in this picture"
    return "expected", (f"steps of {scene.tracing.step_size:g} change what {wrong} pixels see first, and "
                        f"{failing} pixels visibly: thin parts and silhouettes fall between two samples")


def _scene_record(scene: Scene) -> SceneRecord:
    return SceneRecord(
        name=scene.name, title=scene.title or scene.name, figure=scene.figure, description=scene.description,
        estimates=scene.estimates, hash=scene.hash, width=scene.camera.width, height=scene.camera.height,
        samples=scene.tracing.samples, surfaces=[o.surface.type for o in scene.objects],
        objects=[o.name or f"{o.surface.type} {k + 1}" for k, o in enumerate(scene.objects)])
