"""The comparison suite: which renderers meet on which scenes, and what is measured."""

from __future__ import annotations

import datetime
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from pathlib import Path

from raytruth.reference_tracer.scene.model import Scene

from . import document, effects, renderers, studies
from .agreement import matrix, records, tightness
from .attribution.explain import LARGEST, explained
from .attribution.followed import with_histories
from .execution.cluster import engine
from .execution.machine import machine
from .execution.pool import Progress, Silent
from .execution.store import require_folder
from .renderers import RENDERERS
from .results import COMMAND, FILE, Comparison, Results, Run, SceneRecord, joined
from .runs import Request, RunStore
from .verdicts.judge import judge, literal
from .verdicts.pairs import Measurements, Pair
from .verdicts.tolerances import concluded, tolerance_of

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
    cluster: str | None = None  # the address of a Dask scheduler, whose workers make them instead
    with_studies: bool = True
    fresh: bool = False  # whether what the folder says of other scenes and renderers is dropped
    progress: Progress = field(default_factory=Silent)


def compare(scenes: Sequence[Scene], options: Options) -> Results:
    """Runs every renderer on every scene, compares each picture with the truth and with every other one, and writes
    results.json and matrix.json. What a renderer cannot express of a scene is at its default in both pictures that are
    compared (`renderers.nearest`).

    A run that fails costs only its own comparisons. Finished runs and comparisons are kept by content in the folder:
    an interrupted suite goes on where it stopped. What the documents say of other scenes stays, and so do other renderers
    on these scenes, as far as their pictures are kept. Returned is what concerns `scenes`.
    """
    start = time.monotonic()
    require_folder(options.folder)
    scenes = [_fitted(scene, options.largest) for scene in scenes]
    store = RunStore(options.folder)
    earlier = None if options.fresh else document.found(options.folder / FILE, Results, COMMAND)
    names = {scene.name: _compared_on(scene, options.renderers, earlier, store) for scene in scenes}
    planned = studies.planned(scenes) if options.with_studies else []
    both = [(renderers.nearest(scene, first, second).scene, first, second)
            for scene in scenes for first, second in combinations(names[scene.name], 2)]
    by_renderer = {name: k for k, name in enumerate(dict.fromkeys(name for pair in both for name in pair[1:]))}
    requests = [Request(scene, TRUTH) for scene in scenes]
    requests += sorted((Request(scene, name) for scene, *pair in both for name in pair),
                       key=lambda request: by_renderer[request.renderer])
    requests += [request for study in planned for request in study.requests()]
    requests += effects.requests(scenes) + tightness.requests(scenes, options.renderers) if options.with_studies else []
    with engine(options.jobs, options.progress, options.cluster) as pool:
        runs = store.make_all(requests, pool, options.limit)
        measurements = Measurements(options.folder, pool, options.limit)
        made = [Pair(scene, *(runs[Request(scene, name).key] for name in pair)) for scene, *pair in both]
        pairs = [pair for pair in made if pair.first.state == pair.second.state == "ok"]
        more = [pair for study in planned for pair in study.pairs(runs)]
        more += effects.pairs(scenes, runs) + tightness.pairs(scenes, options.renderers, runs) if options.with_studies else []
        measurements.make([*pairs, *more])
        comparisons = [_compared(scene, name, runs, measurements)
                       for scene in scenes for name in names[scene.name] if name != TRUTH]
        comparisons = explained(comparisons, [_fitted(scene, LARGEST) for scene in scenes], runs, options.folder, pool)
        comparisons = with_histories(comparisons, scenes, runs, options.folder, pool)
        rows = tightness.tightness(scenes, options.renderers, runs, measurements) if options.with_studies else []
        found = matrix.matrix(scenes, names, runs, pairs, measurements, comparisons, rows)
        series = [study.series(runs, measurements) for study in planned]
        shown = effects.effects(scenes, runs, measurements) if options.with_studies else []
    before = None if options.fresh else document.found(options.folder / records.FILE, records.Matrix, COMMAND)
    records.write(records.joined(before, found), options.folder)
    results = Results(created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
                      seconds=round(time.monotonic() - start, 1), machine=machine(),
                      scenes=[_scene_record(s) for s in scenes], runs=list(runs.values()), comparisons=comparisons,
                      series=series, effects=shown)
    document.keep(joined(earlier, results), options.folder / FILE, COMMAND)
    return results


def _compared_on(scene: Scene, chosen: Sequence[str], earlier: Results | None, store: RunStore) -> tuple[str, ...]:
    """The truth, the `chosen` renderers, and those that were compared on `scene` before and whose pictures are still there."""
    asked = (TRUTH, *chosen)
    known = {s.name for s in earlier.scenes if s.hash == scene.hash} if earlier else set()
    others = [earlier.run(c.test).renderer for c in earlier.comparisons if c.scene == scene.name] if scene.name in known else []
    return (*asked, *(name for name in dict.fromkeys(others)
                      if name not in asked and name in RENDERERS
                      and store.finished(Request(renderers.nearest(scene, name).scene, name))))


def _fitted(scene: Scene, largest: int) -> Scene:
    width, height, samples = scene.camera.width, scene.camera.height, scene.tracing.samples
    scale = min(largest / max(width, height), (MOST_SAMPLES * largest**2 / (width * height * samples**2)) ** 0.5)
    return scene if scale >= 1 else scene.resized(max(1, round(width * scale)), max(1, round(height * scale)))


def _compared(written: Scene, name: str, runs: dict[str, Run], measurements: Measurements) -> Comparison:
    near = renderers.nearest(written, name)
    scene, (truth, test) = near.scene, (runs[Request(near.scene, who).key] for who in (TRUTH, name))
    told = f"; compared with {near.words}" if near.words else ""
    about = {"id": f"{scene.name}--{name}", "scene": scene.name, "reference": truth.key, "test": test.key,
             "against": "model", "instead": near.words,
             "command": f"raytruth compare {scene.name} --renderers {name} --largest "
                        f"{max(scene.camera.width, scene.camera.height)}"}
    for run in (truth, test):
        if run.state != "ok":
            return Comparison(**about, verdict="not compared", reason=f"{run.title} {run.state}: {run.message}{told}")
    found = measurements.of(Pair(scene, truth, test))
    if found.state != "ok":
        return Comparison(**about, verdict="not compared", reason=f"measuring {found.state}: {found.message}{told}")
    measured = found.metrics
    if test.renderer == "paper":
        verdict, reason, gates = literal(measured, scene.tracing.step_size)
    else:
        verdict, reason, gates = judge(measured, tolerance_of(test), tolerance_of(test, exact=True))
        verdict, reason = concluded(verdict, reason, test)
    return Comparison(**about, verdict=verdict, reason=reason + told, gates=gates, metrics=measured, worst=found.worst)


def _scene_record(scene: Scene) -> SceneRecord:
    return SceneRecord(
        name=scene.name, title=scene.title or scene.name, figure=scene.figure, description=scene.description,
        estimates=scene.estimates, hash=scene.hash, width=scene.camera.width, height=scene.camera.height,
        samples=scene.tracing.samples, surfaces=[o.surface.type for o in scene.objects],
        objects=[o.name or f"{o.surface.type} {k + 1}" for k, o in enumerate(scene.objects)])
