"""Plans a scene: decides parameter by parameter, checks all decisions together, proves them on pixels held back."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce

import numpy as np

from reference_tracer.tracer.render import render
from reference_tracer.scene.model import Scene

from . import halves, mesh, saved
from .decisions import ORDER
from .results import COMMAND, Plan, Proof
from .search import Decision, OutOfTime, Search
from .yardstick import COLOUR, Yardstick

MARGINS = (0.9, 0.5)  # shares of the tolerance that decisions may use: the second if the first plan fails its proof
MOST_SEARCHED = 1 << 25  # camera rays of a picture that is searched on; a larger scene is searched on a smaller picture
LIMIT = 60.0  # seconds for the search
SUFFIX, LONGEST_NAME, LONGEST_TEXT = "-planned", 80, 2000  # of a scene file

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Planned:
    """A plan with its pictures."""

    plan: Plan
    color: np.ndarray  # (h, w, 3), the planned picture
    change: np.ndarray  # (h, w), the largest difference of a channel of every pixel, held back or not


@dataclass
class Attempt:
    margin: float
    decisions: list[Decision]
    planned: Scene
    proof: Proof
    color: np.ndarray  # (h, w, 3), of the planned picture
    change: np.ndarray  # (h, w), of every pixel


def plan(scene: Scene, tolerance: float, *, limit: float = LIMIT, turns: int = saved.TURNS, with_mesh: bool = False,
         progress: Progress = lambda stage, share: None) -> Planned:
    """The plan for `scene`; its tolerance is the largest difference of any channel of a pixel.

    `limit` is in seconds, for the decisions; the proof and the measurement of what is saved come on top.
    """
    start, start_cpu = time.monotonic(), time.process_time()
    progress("the scene as written", 0.0)
    yardstick = Yardstick(scene, tolerance)
    small = fitted(scene)
    searched = yardstick if small.camera == scene.camera else Yardstick(small, tolerance)
    for attempts, margin in enumerate((*MARGINS, 0.0), 1):
        attempt = _attempt(scene, small, yardstick, searched, margin, attempts, limit, progress)
        if attempt.proof.holds:
            break
    seconds, cpu = time.monotonic() - start, time.process_time() - start_cpu
    progress("what is saved", 0.8)
    planned = _named(scene, attempt, tolerance)
    camera = scene.camera
    held_back = ~halves.deciding(scene.hash, camera.height, camera.width, attempts)
    plan = Plan(
        scene=scene.name, title=scene.title, figure=scene.figure, hash=scene.hash, width=camera.width,
        height=camera.height, samples=scene.tracing.samples, tolerance=tolerance, margin=margin, attempts=attempts,
        seconds=round(seconds, 3), cpu_seconds=round(cpu, 3), decisions=[d.record() for d in attempt.decisions],
        proof=attempt.proof,
        saved=saved.measure(scene, planned, turns),
        meshes=mesh.ladder(scene, yardstick, held_back) if with_mesh else [],
        planned=planned.model_dump(mode="json", by_alias=True, exclude_none=True),
        command=f"{COMMAND} {scene.name} --tolerance {tolerance:g}")
    return Planned(plan, attempt.color, attempt.change)


def fitted(scene: Scene) -> Scene:
    """`scene`, smaller if its picture takes more camera rays than a search should trace again and again."""
    camera, samples = scene.camera, scene.tracing.samples
    share = (MOST_SEARCHED / (camera.width * camera.height * samples**2)) ** 0.5
    if share >= 1:
        return scene
    return scene.resized(max(1, int(share * camera.width)), max(1, int(share * camera.height)))


def _attempt(scene: Scene, small: Scene, yardstick: Yardstick, searched: Yardstick, margin: float, number: int,
             limit: float, progress: Progress) -> Attempt:
    mask = lambda s: halves.deciding(scene.hash, s.camera.height, s.camera.width, number)
    decisions = _decide(searched, small, mask(small), margin, limit, progress) if margin else []
    if searched is not yardstick:
        progress("all decisions together", 0.7)
        _withdraw(scene, yardstick, mask(scene), margin, decisions)
    progress("the proof", 0.75)
    planned = applied(scene, decisions)
    color = render(planned, "exact", planes=COLOUR).color
    change = yardstick.from_truth(color)
    held_back = ~mask(scene)
    difference = yardstick.difference(change, held_back, planned.tracing.precision)
    proof = Proof(pixels=change.size, held_back=int(held_back.sum()), largest=difference.largest,
                  excused=difference.excused, excused_largest=difference.excused_largest,
                  most_excused=yardstick.most_excused(held_back), holds=difference.over == 0)
    return Attempt(margin, decisions, planned, proof, color, change)


def _decide(yardstick: Yardstick, scene: Scene, pixels: np.ndarray, margin: float, limit: float,
            progress: Progress) -> list[Decision]:
    """Every decision in turn, each in force as soon as it is made."""
    search = Search(yardstick, scene, pixels, margin * yardstick.tolerance, time.monotonic() + limit)
    decisions: list[Decision] = []
    for k, decide in enumerate(ORDER):
        what = decide.__module__.rpartition(".")[2].replace("_", " ")
        progress(what, 0.05 + 0.65 * k / len(ORDER))
        try:
            for decision in decide(search):
                decisions.append(decision)
                search.scene = applied(scene, decisions)
        except OutOfTime:
            decisions.append(Decision(what, "", "", f"not tried: {limit:g} s were over", None, search.tried()))
    return decisions


def _withdraw(scene: Scene, yardstick: Yardstick, pixels: np.ndarray, margin: float, decisions: list[Decision]) -> None:
    """Takes back the latest decisions until all of them together keep the tolerance at the full size of the picture."""
    changing = [d for d in decisions if d.change]
    while changing:
        planned = applied(scene, decisions)
        limit = margin * yardstick.tolerance
        if not yardstick.difference(yardstick.change(planned), pixels, planned.tracing.precision, limit).over:
            return
        changing.pop().withdrawn = True


def applied(scene: Scene, decisions: list[Decision]) -> Scene:
    return reduce(lambda s, d: d.change(s) if d.change and not d.withdrawn else s, decisions, scene)


def _named(scene: Scene, attempt: Attempt, tolerance: float) -> Scene:
    """The planned scene, with a name of its own and a description that says what was decided."""
    decided = "; ".join(f"{d.parameter}: {d.planned}" for d in attempt.decisions if d.change and not d.withdrawn)
    told = f"Planned for a tolerance of {tolerance:g}: {decided or 'nothing can be left out'}."
    description = f"{scene.description} {told}".strip()
    return attempt.planned.model_copy(update={
        "name": scene.name[:LONGEST_NAME - len(SUFFIX)] + SUFFIX,
        "description": description if len(description) <= LONGEST_TEXT else told[:LONGEST_TEXT]})
