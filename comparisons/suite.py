"""The comparison suite: which renderers meet on which scenes, and what is measured."""

from __future__ import annotations

import datetime
import json
import threading
import time
from collections import deque
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from reference_tracer.scene.model import Scene

from . import effects, metrics, studies
from .agreement import matrix, records, tightness
from .attribution.explain import LARGEST, explained
from .excused import excused
from .gate import excuses, judge, largest_difference, tolerance_of, unmeasured
from .machine import machine
from .process import Worker
from .progress import Progress
from .results import Comparison, Results, Run, SceneRecord, Verdict, read, write
from .runs import Request, RunStore

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
    jobs: int = 2  # runs made at the same time
    with_studies: bool = True
    quiet: bool = False


def compare(scenes: Sequence[Scene], options: Options) -> Results:
    """Runs every renderer on every scene, compares each picture with the truth and with every other one, and writes
    results.json and matrix.json.

    A run that fails costs only its own comparisons. Finished runs and comparisons are kept by content in the folder:
    an interrupted suite goes on where it stopped.
    """
    start = time.monotonic()
    scenes = [_fitted(scene, options.largest) for scene in scenes]
    store = RunStore(options.folder)
    planned = studies.planned(scenes) if options.with_studies else []
    requests = [Request(scene, name) for name in (TRUTH, *options.renderers) for scene in scenes]
    requests += [request for study in planned for request in study.requests()]
    requests += effects.requests(scenes) + tightness.requests(scenes, options.renderers) if options.with_studies else []
    runs = _make_all(list({r.key: r for r in requests}.values()), store, options)

    progress = Progress(len(scenes) * len(options.renderers), options.quiet)
    comparisons = []
    for scene in scenes:
        for name in options.renderers:
            progress.show(f"measuring {scene.name}")
            comparisons.append(_compared(scene, runs[Request(scene, TRUTH).key], runs[Request(scene, name).key], store))
            progress.step()
    progress.close()
    comparisons = explained(comparisons, [_fitted(scene, LARGEST) for scene in scenes], runs, options.folder,
                            jobs=options.jobs, quiet=options.quiet)
    records.write(_matrix(scenes, runs, store, options), options.folder)
    series = [study.series(runs, store) for study in planned]
    shown = effects.effects(scenes, runs, store) if options.with_studies else []
    results = Results(created=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
                      seconds=round(time.monotonic() - start, 1), machine=machine(),
                      scenes=[_scene_record(s) for s in scenes], runs=list(runs.values()), comparisons=comparisons,
                      series=series, effects=shown)
    return _keep(results, options.folder)


def _fitted(scene: Scene, largest: int) -> Scene:
    width, height, samples = scene.camera.width, scene.camera.height, scene.tracing.samples
    scale = min(largest / max(width, height), (MOST_SAMPLES * largest**2 / (width * height * samples**2)) ** 0.5)
    return scene if scale >= 1 else scene.resized(max(1, round(width * scale)), max(1, round(height * scale)))


def _make_all(requests: list[Request], store: RunStore, options: Options) -> dict[str, Run]:
    """All runs by key: finished ones from the store; the others by `jobs` threads, each with a process a renderer."""
    runs = {r.key: run for r in requests if (run := store.finished(r))}
    waiting = deque(r for r in requests if r.key not in runs)
    progress, lock = Progress(len(waiting), options.quiet), threading.Lock()
    started: list[Worker] = []

    def work() -> None:
        with ExitStack() as stack:
            workers: dict[str, Worker] = {}
            while True:
                try:
                    request = waiting.popleft()
                except IndexError:
                    return
                if request.renderer not in workers:
                    workers[request.renderer] = stack.enter_context(Worker())
                    started.append(workers[request.renderer])
                run = store.make(request, workers[request.renderer], options.limit)
                with lock:
                    runs[request.key] = run
                    progress.step(label=f"{request.renderer}: {request.scene.name}")

    with ExitStack() as stack:
        stack.callback(progress.close)
        pool = stack.enter_context(ThreadPoolExecutor(options.jobs))
        try:
            for future in [pool.submit(work) for _ in range(options.jobs)]:
                future.result()
        finally:  # an interrupted suite starts nothing new and waits for nothing; one that is done has nothing left
            waiting.clear()
            for worker in started:
                worker.stop()
    return {r.key: runs[r.key] for r in requests}


def _matrix(scenes: Sequence[Scene], runs: dict[str, Run], store: RunStore, options: Options) -> records.Matrix:
    progress = Progress(len(scenes), options.quiet)
    rows = tightness.tightness(scenes, options.renderers, runs, store) if options.with_studies else []
    with ExitStack() as stack:
        stack.callback(progress.close)
        return matrix.matrix(scenes, (TRUTH, *options.renderers), runs, store, jobs=options.jobs, tightness=rows,
                             done=lambda: progress.step(label="every pair"))


def _compared(scene: Scene, truth: Run, test: Run, store: RunStore) -> Comparison:
    about = {"id": f"{scene.name}--{test.renderer}", "scene": scene.name, "reference": truth.key, "test": test.key,
             "against": "model",
             "command": f"raytruth compare {scene.name} --renderers {test.renderer} --largest "
                        f"{max(scene.camera.width, scene.camera.height)}"}
    for run in (truth, test):
        if run.state != "ok":
            return Comparison(**about, verdict="not compared", reason=f"{run.title} {run.state}: {run.message}")
    measured, worst = _measured(scene, truth, test, store)
    if test.renderer == "paper":
        verdict, reason, gates = *_of_the_literal_method(measured, scene), []
    else:
        limit = largest_difference(test)
        verdict, reason, gates = judge(measured, tolerance_of(test), excuses(measured, limit) if limit else ())
        if verdict == "agrees" and (why := unmeasured(test)):
            verdict, reason = "not compared", why
    return Comparison(**about, verdict=verdict, reason=reason, gates=gates, metrics=measured, worst=worst)


def _measured(scene: Scene, truth: Run, test: Run, store: RunStore):
    """The metrics and the worst pixels of two finished runs, measured once and kept."""
    kept = store.folder / "measured" / f"{truth.key}-{test.key}.json"
    try:
        record = json.loads(kept.read_text(encoding="utf-8"))
        return record["metrics"], record["worst"]
    except (OSError, ValueError, KeyError):
        pass
    a, b = store.planes(truth, scene), store.planes(test, scene)
    measured = {**metrics.geometry(a, b), **metrics.picture(a, b)}
    if limit := largest_difference(test):
        measured |= excused(scene, a, b, limit, test.facts["precision"], store.folder, SECONDS_PER_RUN)
    worst = metrics.worst_pixels(metrics.pixel_error(a["color"], b["color"]))
    kept.parent.mkdir(exist_ok=True)
    part = kept.with_suffix(".part")
    part.write_text(json.dumps({"metrics": measured, "worst": worst}), encoding="utf-8")
    part.replace(kept)
    return measured, worst


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


def _keep(results: Results, folder: Path) -> Results:
    """Writes the results, unless the folder already holds the same ones of an earlier time."""
    try:
        earlier = read(folder)
        if earlier.model_copy(update={"created": "", "seconds": 0}) == results.model_copy(
                update={"created": "", "seconds": 0}):
            return earlier
    except Exception:  # none, or unreadable: it is replaced
        pass
    write(results, folder)
    return results
