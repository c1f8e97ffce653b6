"""Measures a study of growth."""

from __future__ import annotations

from functools import partial

import numpy as np

from reference_tracer.tracer.image_files import load_npz
from reference_tracer.scene.model import Scene

from ..bench.timing import QUIET
from ..verdicts.metrics import pixel_error
from ..planes import problem
from .growth import SECONDS, Study
from .results import Growth, GrowthLine, GrowthPoint, clock
from .store import ChartStore
from .sweeps import OURS, Contestant
from .team import Team
from .turns import take_turns


def measured(study: Study, turns: int, store: ChartStore, team: Team) -> Growth:
    """The study's record; one without a failure is kept."""
    scenes = {x: study.scene(x) for x in study.values}
    key = store.key(next(iter(scenes.values())), study.id, [s.hash for s in scenes.values()], study.values, study.lines)
    kept = store.find(key, Growth.model_validate_json)
    if kept:
        return kept
    growth = _Growing(study, scenes, store, team).growth(turns)
    if all(p.state == "ok" for line in growth.lines for p in line.points):
        store.keep(key, growth)
    return growth


class _Growing:
    def __init__(self, study: Study, scenes: dict[float, Scene], store: ChartStore, team: Team):
        self.study, self.scenes, self.store, self.team = study, scenes, store, team

    def growth(self, turns: int) -> Growth:
        study = self.study
        scene = study.reference()
        reference = self._first("reference", {"method": "exact"}, 0, scene)[0] if scene else None
        points, seconds = {}, {}
        for label, settings in study.lines:
            for x, scene in self.scenes.items():
                color, answer = self._first(label, settings, x, scene)
                facts = answer.get("facts", {})
                points[label, x] = GrowthPoint(x=x, state=answer["state"], message=answer.get("message", ""),
                                               rays=facts.get("rays"), peak_mib=facts.get("peak_mib"))
                seconds[label, x] = _second(study, scene, facts, color, reference)
        settings = dict(study.lines)
        timed = take_turns({(label, x): partial(
            self.team.timed, self._id(label, x), self.scenes[x], Contestant(OURS, settings[label]),
            threads=self._threads(x), hits=False)
            for (label, x), point in points.items() if point.state == "ok"}, turns)
        for key, found in timed.items():
            points[key] = points[key].model_copy(
                update={"picture": found.times(), "second": seconds[key], **found.fault})
        if study.second == "efficiency":
            points = {key: _with_efficiency(point, points[key[0], study.values[0]]) for key, point in points.items()}
        lines = [GrowthLine(label=label, points=[points[label, x] for x in self.scenes]) for label, _ in study.lines]
        facts = [f for found in timed.values() for f in found.facts]
        others = sum(f["others"] for f in facts) / max(sum(f["seconds"] for f in facts), 1e-9)
        return Growth(id=study.id, title=study.title, x_label=study.x_label, second_label=SECONDS[study.second],
                      lines=lines, finding=_finding(study, lines, others), others=others,
                      command="raytruth chart --growth " + study.id)

    def _id(self, label: str, x: float) -> str:
        return f"{self.study.id} {label} {x:g}"

    def _threads(self, x: float) -> int | None:
        return int(x) if self.study.x_is_threads else None

    def _first(self, label: str, settings: dict, x: float, scene: Scene) -> tuple[np.ndarray | None, dict]:
        """The colours of the first picture, and the answer."""
        id = self._id(label, x)
        file = self.team.planes(id)
        try:
            answer = self.team.firsts(scene, {id: Contestant(OURS, settings)}, threads=self._threads(x))[id]
            if answer["state"] == "ok" and (wrong := problem(file, scene)):
                answer = {"state": "malformed", "message": wrong}
            return (load_npz(file)[0]["color"] if answer["state"] == "ok" else None), answer
        finally:
            file.unlink(missing_ok=True)


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
    told = []
    for line in lines:
        done = [p for p in line.points if p.picture and p.second]
        if len(done) < 2:
            continue
        first, last = done[0], done[-1]
        time = lambda p: getattr(p.picture, clock([others])).median
        if study.x_is_threads:
            best = min(done, key=lambda p: p.picture.wall.median)
            share = best.picture.wall.median / first.picture.wall.median
            told.append(f"at best, with {best.x:g} of up to {last.x:g} threads, a picture takes {share:.2f} of the "
                        f"time with one: an efficiency of {best.second:.0%}"
                        + (f" (other programs kept {others:.1f} cores busy)" if others >= QUIET else ""))
        else:
            told.append(f"{line.label}: with {last.x / first.x:.3g} times the {study.x_label}, "
                        f"{time(last) / time(first):.3g} times the time and {last.second / first.second:.3g} times the "
                        f"{study.second}")
    return "; ".join([*told, study.remark] if told and study.remark else told)
