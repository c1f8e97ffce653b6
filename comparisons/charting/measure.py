"""Charts every subject: the truth first, then every contestant's accuracy, then their times, interleaved; and growth.

What is timed is never what is judged. Finished measurements are kept by all that can change them, the machine and the
number of turns among it.
"""

from __future__ import annotations

import math
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.image_files import load_npz

from ..bench.document import Spread
from ..bench.timing import QUIET, spread
from ..execution import store
from ..execution.machine import machine
from ..execution.pool import Pool, Progress, Silent, Task
from ..planes import problem
from ..renderers import RENDERERS
from ..suites import head
from ..verdicts.metrics import Planes, pixel_error
from . import truth as truths
from .cases import OURS, SECONDS, SWEEPS, Charted, Contestant, Study, Sweep
from .document import FOLDER, Chart, Growth, GrowthLine, GrowthPoint, Point, Series, Subject, Times, clock
from .findings import findings
from .truth import Truth, accuracy, uncertainty

Answer = dict  # see Worker.ask


@dataclass(frozen=True)
class Options:
    folder: Path
    full: bool = False
    turns: int = 3
    limit: float = 120.0  # seconds an answer may take
    patience: float = 30.0  # seconds that all turns of one point may take
    progress: Progress = field(default_factory=Silent)


def run(subjects: Sequence[Charted], studies: Sequence[Study], options: Options,
        sweeps: Sequence[Sweep] = SWEEPS) -> Chart:
    """The document of `subjects` and of the growth `studies`. What is finished is kept by content in the folder."""
    start, progress = time.monotonic(), options.progress
    kept = ChartStore(options.folder, options.turns)
    progress.expect(len(subjects) + len(studies))
    with Workers(options.limit) as workers:
        def each(label: str, measure: Callable, *arguments):
            progress.begin(label)
            began = time.monotonic()
            found = measure(*arguments, options, kept, workers)
            progress.end(label, time.monotonic() - began, getattr(found, "state", "ok"))
            return found

        charted = [each(subject.scene.name, _subject, subject, sweeps) for subject in subjects]
        grown = [each(study.title, _growth, study) for study in studies]
    return Chart(**head(start), threads=len(os.sched_getaffinity(0)), turns=options.turns, truth=truths.ABOUT,
                 subjects=charted, growths=grown)


class ChartStore(store.Store):
    """The folder `chart/` of a results folder."""

    def __init__(self, folder: Path, turns: int):
        super().__init__(folder, FOLDER)
        here = machine()
        self._always = [turns, here.processor, here.cores]

    def key(self, scene: Scene, *content, renderer: str = "") -> str:
        """`renderer` is who is measured; ours, if it is none of the suite's."""
        found = RENDERERS.get(renderer)
        return store.key(scene.hash, *content, self._always, found.content if found else renderer,
                         made_by=("raytruth.comparisons.charting.worker", "raytruth.comparisons.charting.competitors",
                                  *(found.code if found else ())))


# --- workers ----------------------------------------------------------------------------------------------------------
class Workers:
    """Processes that measure, one a kind of renderer, which last so that recordings are replayed.

    Where nothing is timed, two work at a time; else one. `limit` is in seconds, of one answer.
    """

    def __init__(self, limit: float):
        self.limit = limit

    def __enter__(self) -> Workers:
        self._folder, self._pool = Path(tempfile.mkdtemp(prefix="raytruth-chart-")), Pool(2, lasting=True)
        return self

    def __exit__(self, *_) -> None:
        self._pool.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def truth(self, scene: Scene, path: Path) -> Answer:
        """Made in a process of its own, whose kernels nobody finds compiled."""
        return self._pool.ask(self._task("truth", "truth", {"do": "truth", "scene": _text(scene), "truth": str(path)}))

    def pictures(self, scene: Scene, contestants: dict[str, Contestant], truth: Path | None = None,
                 threads: int | None = None) -> Iterator[tuple[str, Planes | None, Answer]]:
        """The pictures that are judged, by the ids of their contestants; None for one that is not to be had."""
        planes = lambda id: self._folder / f"{id}.npz"
        tasks = [self._of("first", id, scene, contestant, truth, threads, planes=str(planes(id)))
                 for id, contestant in contestants.items()]
        for task, answer in self._pool.run(tasks):
            file = planes(task.key)
            if answer["state"] == "ok" and (wrong := problem(file, scene)):
                answer = {"state": "malformed", "message": wrong}
            try:
                yield task.key, load_npz(file)[0] if answer["state"] == "ok" else None, answer
            finally:
                file.unlink(missing_ok=True)

    def timed(self, id: str, scene: Scene, contestant: Contestant, truth: Path | None = None,
              threads: int | None = None, hits: bool = True) -> Answer:
        """One turn."""
        return self._pool.ask(self._of("timed", id, scene, contestant, truth, threads, hits=hits))

    def _of(self, do: str, id: str, scene: Scene, contestant: Contestant, truth: Path | None, threads: int | None,
            **more) -> Task:
        return self._task(id, contestant.process, {
            "do": do, "id": id, "scene": _text(scene), "renderer": contestant.renderer, "settings": contestant.settings,
            "timed": contestant.timed, "truth": str(truth) if truth else None, "threads": threads, **more})

    def _task(self, id: str, process: str, arguments: dict) -> Task:
        return Task(id, id, "raytruth.comparisons.charting.worker:answer",
                    {**arguments, "kernels": str(self._folder / process)}, self.limit, process)


def _text(scene: Scene) -> str:
    return scene.model_dump_json(by_alias=True)


@dataclass(frozen=True)
class Timed:
    """What came of one contestant's turns; `failure` is the answer that ended them early, if one did."""

    facts: list[dict]
    failure: Answer | None = None

    def times(self, prefix: str = "") -> Times | None:
        """The times called `prefix`wall and `prefix`cpu; None where they were not taken."""
        wall, cpu = self._spread(f"{prefix}wall"), self._spread(f"{prefix}cpu")
        return Times(wall=wall, cpu=cpu) if wall and cpu else None

    @property
    def fault(self) -> dict:
        """State and message of the failure; empty if there is none."""
        return {"state": self.failure["state"], "message": self.failure.get("message", "")} if self.failure else {}

    @property
    def build(self) -> Spread | None:
        return self._spread("build")

    @property
    def others(self) -> float:
        return others_of(self.facts)

    def _spread(self, name: str) -> Spread | None:
        values = [f[name] for f in self.facts if f.get(name) is not None]
        return spread(values) if values else None


def others_of(facts: list[dict]) -> float:
    """Cores that other programs kept busy."""
    return sum(f["others"] for f in facts) / max(sum(f["seconds"] for f in facts), 1e-9)


def interleave(contestants: dict[Hashable, Callable[[], Answer]], turns: int,
               patience: float = math.inf) -> dict[Hashable, Timed]:
    """Asks every contestant `turns` times, A B C A B C ..., so that whatever slows the machine down slows all alike; one
    that fails, or whose turns have taken `patience` seconds, no more."""
    facts: dict[Hashable, list[dict]] = {name: [] for name in contestants}
    failures: dict[Hashable, Answer] = {}
    for _ in range(turns):
        for name, ask in contestants.items():
            if name in failures or sum(f["seconds"] for f in facts[name]) > patience:
                continue
            answer = ask()
            if answer["state"] == "ok":
                facts[name].append(answer["facts"])
            else:
                failures[name] = answer
    return {name: Timed(facts[name], failures.get(name)) for name in contestants}


# --- subjects ---------------------------------------------------------------------------------------------------------
def _subject(subject: Charted, sweeps: Sequence[Sweep], options: Options, kept: ChartStore, workers: Workers) -> Subject:
    scene = subject.scene
    about = {"id": scene.name, "title": scene.title or scene.name, "kind": subject.kind, "width": scene.camera.width,
             "height": scene.camera.height, "objects": len(scene.objects),
             "command": f"raytruth chart {scene.name} --size {scene.camera.width}x{scene.camera.height}"
                        + (" --full" if options.full else "")}
    key = kept.key(scene, "truth")
    arrays = kept.arrays(key)
    if arrays is None:
        answer = workers.truth(scene, kept.file(key))
        if answer["state"] != "ok":
            return Subject(**about, pixels=0, undecided=0, uncertainty=None, state=answer["state"],
                           message=answer.get("message", ""), series=[], findings=[])
        kept.keep(key, {}, arrays=True)
        arrays = kept.arrays(key)
    truth = truths.of_arrays(arrays)
    series = _series(scene, sweeps, truth, kept.file(key), options, kept, workers)
    decisive = clock([p.others for s in series for p in s.points if p.turns])
    return Subject(**about, pixels=int(truth.decided.sum()), undecided=truth.undecided, uncertainty=uncertainty(truth),
                   series=series, findings=findings(series, decisive))


def _series(scene: Scene, sweeps: Sequence[Sweep], truth: Truth, truth_file: Path, options: Options, kept: ChartStore,
            workers: Workers) -> list[Series]:
    entries: dict[str, tuple[Sweep, float | None, Contestant]] = {}  # by the key that names their files
    keys: dict[str, list[str]] = {sweep.id: [] for sweep in sweeps}
    for sweep in (s for s in sweeps if s.is_registered):
        for value, contestant in sweep.contestants(options.full):
            key = kept.key(scene, contestant.settings, contestant.timed, renderer=contestant.renderer)
            entries[key] = sweep, value, contestant
            keys[sweep.id].append(key)
    points = {key: found for key in entries if (found := kept.find(key, Point.model_validate_json))}
    waiting = {key: contestant for key, (_, _, contestant) in entries.items() if key not in points}
    judged, first = {}, {}
    # ours are judged beside the others: what is not timed may have company
    for key, planes, answer in workers.pictures(scene, waiting, truth_file):
        facts = answer.get("facts", {})
        first[key] = facts.get("first", 0.0)
        sweep, value, contestant = entries[key]
        about = {"label": sweep.label(value), "value": value, "settings": contestant.settings}
        judged[key] = Point(**about, state=answer["state"], message=answer.get("message", "")) if planes is None else Point(
            **about, state="ok", accuracy=accuracy(truth, planes), evaluations=facts["evaluations"],
            peak_mib=facts["peak_mib"])
    timed = interleave({key: partial(workers.timed, key, scene, contestant, truth_file)
                        for key, contestant in waiting.items() if judged[key].state == "ok"},
                       options.turns, options.patience)
    for key, point in judged.items():
        points[key] = _with_times(point, first[key], timed[key]) if key in timed else point
        kept.keep(key, points[key])
    return [Series(id=sweep.id, method=sweep.method, title=sweep.title, kind=sweep.kind, parameter=sweep.parameter,
                   points=[points[key].model_copy(update={"label": sweep.label(entries[key][1])}) for key in keys[sweep.id]]
                   if sweep.is_registered else [_unregistered(sweep)]) for sweep in sweeps]


def _with_times(point: Point, first: float, timed: Timed) -> Point:
    """The point with the times of its turns; `first` are the wall seconds of its first picture."""
    if timed.failure:
        return point.model_copy(update=timed.fault)
    picture = timed.times()
    return point.model_copy(update={
        "picture": picture, "hits": timed.times("hits_"), "build": timed.build, "turns": len(timed.facts),
        "others": timed.others, "compiling": max(first - picture.wall.median, 0.0)})


def _unregistered(sweep: Sweep) -> Point:
    return Point(label="", value=None, settings=sweep.settings, state="missing",
                 message=f"this raytruth knows no renderer {sweep.renderer!r}")


# --- growth -----------------------------------------------------------------------------------------------------------
def _growth(study: Study, options: Options, kept: ChartStore, workers: Workers) -> Growth:
    """The study's record; one without a failure is kept."""
    scenes = {x: study.scene(x) for x in study.values}
    key = kept.key(next(iter(scenes.values())), study.id, [s.hash for s in scenes.values()], study.values, study.lines)
    if found := kept.find(key, Growth.model_validate_json):
        return found
    growth = _grown(study, scenes, options.turns, workers)
    if all(p.state == "ok" for line in growth.lines for p in line.points):
        kept.keep(key, growth)
    return growth


def _grown(study: Study, scenes: dict[float, Scene], turns: int, workers: Workers) -> Growth:
    name = lambda label, x: f"{study.id} {label} {x:g}"
    threads = lambda x: int(x) if study.x_is_threads else None

    def first(label: str, settings: dict, x: float, scene: Scene) -> tuple[np.ndarray | None, Answer]:
        """The colours of the first picture, and the answer."""
        (_, planes, answer), = workers.pictures(scene, {name(label, x): Contestant(OURS, settings)}, threads=threads(x))
        return planes and planes["color"], answer

    scene = study.reference()
    reference = first("reference", {"method": "exact"}, 0, scene)[0] if scene else None
    points, second, settings = {}, {}, dict(study.lines)
    for label in settings:
        for x, scene in scenes.items():
            color, answer = first(label, settings[label], x, scene)
            facts = answer.get("facts", {})
            points[label, x] = GrowthPoint(x=x, state=answer["state"], message=answer.get("message", ""),
                                           rays=facts.get("rays"), peak_mib=facts.get("peak_mib"))
            second[label, x] = _second(study, scene, facts, color, reference)
    timed = interleave({(label, x): partial(workers.timed, name(label, x), scenes[x], Contestant(OURS, settings[label]),
                                            threads=threads(x), hits=False)
                        for (label, x), point in points.items() if point.state == "ok"}, turns)
    for key, found in timed.items():
        points[key] = points[key].model_copy(update={"picture": found.times(), "second": second[key], **found.fault})
    if study.second == "efficiency":
        points = {key: _with_efficiency(point, points[key[0], study.values[0]]) for key, point in points.items()}
    lines = [GrowthLine(label=label, points=[points[label, x] for x in scenes]) for label in settings]
    others = others_of([f for found in timed.values() for f in found.facts])
    return Growth(id=study.id, title=study.title, x_label=study.x_label, second_label=SECONDS[study.second], lines=lines,
                  finding=_finding(study, lines, others), others=others, command="raytruth chart --growth " + study.id)


def _second(study: Study, scene: Scene, facts: dict, color, reference) -> float | None:
    match study.second:
        case "error" if color is not None and reference is not None:
            return float(np.nanmean(pixel_error(color, reference)))
        case "memory":
            return facts.get("peak_mib")
        case "rays" if facts.get("rays"):
            return facts["rays"] / (scene.camera.width * scene.camera.height)
        case "evaluations":
            return facts.get("evaluations")
    return None


def _with_efficiency(point: GrowthPoint, one: GrowthPoint) -> GrowthPoint:
    if not point.picture or not one.picture:
        return point
    return point.model_copy(update={"second": one.picture.wall.median / (point.x * point.picture.wall.median)})


def _finding(study: Study, lines: list[GrowthLine], others: float) -> str:
    """From the first value to the last: by what factor time and the other thing changed."""
    sentences = []
    time = lambda p: getattr(p.picture, clock([others])).median
    for line in lines:
        done = [p for p in line.points if p.picture and p.second]
        if len(done) < 2:
            continue
        first, last = done[0], done[-1]
        if study.x_is_threads:
            best = min(done, key=lambda p: p.picture.wall.median)
            share = best.picture.wall.median / first.picture.wall.median
            sentences.append(f"at best, with {best.x:g} of up to {last.x:g} threads, a picture takes {share:.2f} of the "
                             f"time with one: an efficiency of {best.second:.0%}"
                             + (f" (other programs kept {others:.1f} cores busy)" if others >= QUIET else ""))
        else:
            sentences.append(f"{line.label}: with {last.x / first.x:.3g} times the {study.x_label}, "
                             f"{time(last) / time(first):.3g} times the time and {last.second / first.second:.3g} times "
                             f"the {study.second}")
    return "; ".join([*sentences, study.remark] if sentences and study.remark else sentences)
