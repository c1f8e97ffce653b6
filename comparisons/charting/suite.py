"""Charts every subject: the truth first, then every contestant's accuracy, then their times in turns."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from reference_tracer.tracer.image_files import load_npz

from ..execution.machine import machine
from ..planes import problem
from ..execution.pool import Progress, Silent
from . import truth as truths
from .accuracy import accuracy, uncertainty
from .findings import findings
from .growth import Study
from .growing import measured
from .results import Chart, Point, Series, Subject, clock
from .store import ChartStore
from .subjects import Charted
from .sweeps import SWEEPS, Contestant, Sweep
from .team import Team
from .truth import Truth
from .turns import Timed, take_turns


@dataclass(frozen=True)
class Options:
    folder: Path
    full: bool = False
    turns: int = 3
    limit: float = 120.0  # seconds an answer may take
    patience: float = 30.0  # seconds that all turns of one point may take
    progress: Progress = field(default_factory=Silent)


@dataclass(frozen=True)
class _Entry:
    """One point to be measured. `key` names its files."""

    sweep: Sweep
    value: float | None
    contestant: Contestant
    key: str

    def point(self, **more) -> Point:
        return Point(label=self.sweep.label(self.value), value=self.value, settings=self.contestant.settings, **more)


def run(subjects: Sequence[Charted], studies: Sequence[Study], options: Options, sweeps: Sequence[Sweep] = SWEEPS,
        team: Team | None = None) -> Chart:
    """The document of `subjects` and of the growth `studies`. What is finished is kept by content in the folder."""
    start = time.monotonic()
    store, progress = ChartStore(options.folder, options.turns), options.progress
    progress.expect(len(subjects) + len(studies))
    with team or Team(options.limit) as asked:
        charted, grown = [], []
        for subject in subjects:
            progress.begin(subject.scene.name)
            began = time.monotonic()
            charted.append(_Subject(subject, sweeps, options, store, asked).charted())
            progress.end(subject.scene.name, time.monotonic() - began, charted[-1].state)
        for study in studies:
            progress.begin(study.title)
            began = time.monotonic()
            grown.append(measured(study, options.turns, store, asked))
            progress.end(study.title, time.monotonic() - began, "ok")
    return Chart(created=datetime.now(UTC).isoformat(timespec="seconds"), seconds=round(time.monotonic() - start, 1),
                 machine=machine(), threads=len(os.sched_getaffinity(0)), turns=options.turns, truth=truths.TOLD,
                 subjects=charted, growths=grown)


class _Subject:
    """The measuring of one subject."""

    def __init__(self, subject: Charted, sweeps: Sequence[Sweep], options: Options, store: ChartStore, team: Team):
        self.scene, self.kind, self.options, self.store, self.team = subject.scene, subject.kind, options, store, team
        self.sweeps = sweeps
        self.truth_key = store.key(self.scene, "truth")
        self.truth_file = store.file(self.truth_key)

    def charted(self) -> Subject:
        scene = self.scene
        about = {"id": scene.name, "title": scene.title or scene.name, "kind": self.kind, "width": scene.camera.width,
                 "height": scene.camera.height, "objects": len(scene.objects),
                 "command": f"raytruth chart {scene.name} --size {scene.camera.width}x{scene.camera.height}"
                            + (" --full" if self.options.full else "")}
        truth, answer = self._truth()
        if truth is None:
            return Subject(**about, pixels=0, undecided=0, uncertainty=None, state=answer["state"],
                           message=answer.get("message", ""), series=[], findings=[])
        series = self._series(truth)
        decisive = clock([p.others for s in series for p in s.points if p.turns])
        return Subject(**about, pixels=int(truth.decided.sum()), undecided=truth.undecided,
                       uncertainty=uncertainty(truth), series=series, findings=findings(series, decisive))

    def _truth(self) -> tuple[Truth | None, dict]:
        arrays, answer = self.store.arrays(self.truth_key), {"state": "ok"}
        if arrays is None:
            answer = self.team.truth(self.scene, self.truth_file)
            if answer["state"] != "ok":
                return None, answer
            self.store.keep(self.truth_key, {}, arrays=True)
            arrays = self.store.arrays(self.truth_key)
        return truths.of_arrays(arrays), answer

    def _series(self, truth: Truth) -> list[Series]:
        entries = {sweep.id: [_Entry(sweep, value, contestant, self._key(contestant))
                              for value, contestant in sweep.contestants(self.options.full)]
                   for sweep in self.sweeps if sweep.is_registered}
        every = [entry for sweep in entries.values() for entry in sweep]
        points = {entry.key: kept for entry in every if (kept := self.store.find(entry.key, Point.model_validate_json))}
        waiting = {entry.key: entry for entry in every if entry.key not in points}
        judged = self._all_judged(waiting, truth)
        timed = take_turns({key: lambda entry=waiting[key]: self.team.timed(
            entry.key, self.scene, entry.contestant, self.truth_file) for key, (point, _) in judged.items()
            if point.state == "ok"}, self.options.turns, self.options.patience)
        for key, (point, first) in judged.items():
            points[key] = _with_times(point, first, timed[key]) if key in timed else point
            self.store.keep(key, points[key])
        return [Series(id=sweep.id, method=sweep.method, title=sweep.title, kind=sweep.kind, parameter=sweep.parameter,
                       points=[points[entry.key].model_copy(update={"label": sweep.label(entry.value)})
                               for entry in entries[sweep.id]]
                       if sweep.is_registered else [_unregistered(sweep)]) for sweep in self.sweeps]

    def _all_judged(self, waiting: dict[str, _Entry], truth: Truth) -> dict[str, tuple[Point, float]]:
        """All points without times. Ours are judged beside the others: what is not timed may have company."""
        answers = self.team.firsts(self.scene, {key: entry.contestant for key, entry in waiting.items()}, self.truth_file)
        return {key: self._judged(entry, answers[key], truth) for key, entry in waiting.items()}

    def _key(self, contestant: Contestant) -> str:
        return self.store.key(self.scene, contestant.settings, contestant.timed, renderer=contestant.renderer)

    def _judged(self, entry: _Entry, answer: dict, truth: Truth) -> tuple[Point, float]:
        """The point without times, and the wall seconds of its first picture."""
        file = self.team.planes(entry.key)
        try:
            state, message = answer["state"], answer.get("message", "")
            if state == "ok" and (wrong := problem(file, self.scene)):
                state, message = "malformed", wrong
            if state != "ok":
                return entry.point(state=state, message=message), 0.0
            planes, _ = load_npz(file)
            facts = answer["facts"]
            return entry.point(state="ok", accuracy=accuracy(truth, planes), evaluations=facts["evaluations"],
                               peak_mib=facts["peak_mib"]), facts["first"]
        finally:
            file.unlink(missing_ok=True)


def _with_times(point: Point, first: float, timed: Timed) -> Point:
    if timed.failure:
        return point.model_copy(update=timed.fault)
    picture = timed.times()
    return point.model_copy(update={
        "picture": picture, "hits": timed.times("hits_"), "build": timed.build, "turns": len(timed.facts),
        "others": timed.others, "compiling": max(first - picture.wall.median, 0.0)})


def _unregistered(sweep: Sweep) -> Point:
    return Point(label="", value=None, settings=sweep.settings, state="missing",
                 message=f"this raytruth knows no renderer {sweep.renderer!r}")
