"""Plans scenes in workers: decides parameter by parameter, checks all decisions together on pixels held back, and times
what they save. One plan at a time, because plans are timed; what is finished is kept by its content."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial, reduce
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.image_files import to_8_bit
from raytruth.reference_tracer.tracer.render import Picture, Renderer, render

from ..bench.timing import Contestant, interleave, timed
from ..bench.timing import deciding as deciding_clock
from ..execution import store
from ..execution.machine import machine
from ..execution.pool import Pool, Progress, Task, complete
from ..execution.store import Store
from ..execution.worker import tell
from ..runs import Request, RunStore
from ..suites import reader
from .decisions import ORDER
from .document import COMMAND, PLANES, MeshTrial, Plan, Planning, Proof, Ratio, Saved, add
from .search import COLOUR, Decision, OutOfTime, Search, Yardstick, deciding

MARGINS = (0.9, 0.5)  # shares of the tolerance that decisions may use: the second if the first plan fails its check
MOST_SEARCHED = 1 << 25  # camera rays of a picture that is searched on; a larger scene is searched on a smaller picture
LIMIT, LONGEST = 60.0, 3600.0  # seconds for the search; of one plan, since decisions have a limit of their own
SUFFIX, LONGEST_NAME, LONGEST_TEXT = "-planned", 80, 2000  # of a scene file
TURNS, BUDGET = 9, 20.0  # pairs of timed runs; seconds for them
MESHES, MESH_LIMIT = (32, 64, 128, 256, 512), 120.0  # resolutions; seconds of a run

Stages = Callable[[str, float], None]  # is called with what is done, and the share of the whole


def run(scenes: Sequence[Scene], tolerance: float, folder: Path | None, *, limit: float = LIMIT,
        with_mesh: bool = False, progress: Progress | None = None) -> Iterator[Planning]:
    """The plan of every scene as soon as it is made, then also part of the document in `folder`, if there is one.

    `limit` is in seconds, for the decisions of one scene.
    """
    with ExitStack() as stack:
        kept = Store(folder or Path(stack.enter_context(TemporaryDirectory(prefix="raytruth-plan-"))), PLANES)
        pool, here = stack.enter_context(Pool(1, progress)), machine()
        for scene in scenes:
            key = store.key(scene.hash, scene.name, tolerance, limit, with_mesh, here.processor, here.cores,
                            made_by=(__name__,))
            task = Task(key, scene.name, f"{__name__}:answer", {
                "scene": scene.model_dump_json(by_alias=True), "tolerance": tolerance, "limit": limit,
                "with_mesh": with_mesh, "planes": str(kept.file(key))}, LONGEST)
            planning = complete([task], kept, pool, Planning.model_validate_json, partial(_settled, kept), arrays=True)[key]
            if planning.plan and folder is not None:
                add(planning.plan, folder)
            yield planning


def _settled(kept: Store, task: Task, answer: dict) -> Planning:
    planning = reader(Planning, "plan")(task, answer)
    if planning.plan is None:
        return planning
    return planning.model_copy(update={"plan": planning.plan.model_copy(update={"planes": kept.relative(task.key)})})


def answer(arguments: dict) -> dict:
    """In a worker: plans a scene, and writes its pictures."""
    found = plan(parse_scene(arguments["scene"].encode(), "scene"), arguments["tolerance"],
                 limit=arguments["limit"], with_mesh=arguments["with_mesh"], progress=tell)
    store.save(Path(arguments["planes"]), color=to_8_bit(found.color), change=found.change.astype(np.float32))
    return {"state": "ok", "plan": found.plan.model_dump(mode="json")}


@dataclass(frozen=True)
class Planned:
    """A plan with its pictures."""

    plan: Plan
    color: np.ndarray  # (h, w, 3), the planned picture
    change: np.ndarray  # (h, w), the largest difference of a channel of every pixel, held back or not


@dataclass
class Attempt:
    """Decisions that may use a `margin` of the tolerance, and what the scene is with them."""

    margin: float
    decisions: list[Decision]
    planned: Scene
    proof: Proof
    color: np.ndarray  # (h, w, 3), of the planned picture
    change: np.ndarray  # (h, w), of every pixel


def plan(scene: Scene, tolerance: float, *, limit: float = LIMIT, turns: int = TURNS, with_mesh: bool = False,
         progress: Stages = lambda stage, share: None) -> Planned:
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
    held_back = ~deciding(scene.hash, camera.height, camera.width, attempts)
    plan = Plan(
        scene=scene.name, title=scene.title, figure=scene.figure, hash=scene.hash, width=camera.width,
        height=camera.height, samples=scene.tracing.samples, tolerance=tolerance, margin=margin, attempts=attempts,
        seconds=round(seconds, 3), cpu_seconds=round(cpu, 3), decisions=[d.record() for d in attempt.decisions],
        proof=attempt.proof, saved=saved(scene, planned, turns),
        meshes=mesh_trials(scene, yardstick, held_back) if with_mesh else [],
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
             limit: float, progress: Stages) -> Attempt:
    mask = lambda s: deciding(scene.hash, s.camera.height, s.camera.width, number)
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
            progress: Stages) -> list[Decision]:
    """Every decision in turn, each in force as soon as it is made."""
    search = Search(yardstick, scene, pixels, margin * yardstick.tolerance, time.monotonic() + limit)
    decisions: list[Decision] = []
    for k, decide in enumerate(ORDER):
        what = decide.__name__.replace("_", " ")
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
    """The scene with all decisions that are in force."""
    return reduce(lambda s, d: d.change(s) if d.change and not d.withdrawn else s, decisions, scene)


def _named(scene: Scene, attempt: Attempt, tolerance: float) -> Scene:
    """The planned scene, with a name of its own and a description that says what was decided."""
    decided = "; ".join(f"{d.parameter}: {d.planned}" for d in attempt.decisions if d.change and not d.withdrawn)
    note = f"Planned for a tolerance of {tolerance:g}: {decided or 'nothing can be left out'}."
    description = f"{scene.description} {note}".strip()
    return attempt.planned.model_copy(update={
        "name": scene.name[:LONGEST_NAME - len(SUFFIX)] + SUFFIX,
        "description": description if len(description) <= LONGEST_TEXT else note[:LONGEST_TEXT]})


def saved(written: Scene, planned: Scene, turns: int = TURNS) -> Saved:
    """Ratios of time, everything compiled before: of the colours of a scene that is made ready, as for every picture
    after the first; and of a call of `render` with all planes and everything it does each time."""
    ready = {"planned": Renderer(planned), "exact": Renderer(written, "exact"), "paper": Renderer(written, "paper")}
    work: dict[str, Callable[[], Picture]] = {
        **{name: lambda renderer=renderer: renderer.picture(COLOUR) for name, renderer in ready.items()},
        "planned, whole call": lambda: render(planned), "exact, whole call": lambda: render(written)}
    rays: dict[str, int] = {}

    def contestant(name: str) -> Contestant:
        def run():
            pictures = []
            cost = timed(lambda: pictures.append(work[name]()))
            rays[name] = pictures[0].metadata["rays"]
            return cost
        return Contestant(name, run)

    measured = interleave([contestant(name) for name in work], turns, BUDGET)
    clock = deciding_clock(None, measured.others)

    def ratio(slow: str, fast: str) -> Ratio:
        return Ratio(wall=measured.ratio(slow, fast, "wall"), cpu=measured.ratio(slow, fast, "cpu"), clock=clock)

    return Saved(exact=ratio("exact", "planned"), paper=ratio("paper", "planned"),
                 call=ratio("exact, whole call", "planned, whole call"), turns=len(measured.costs["planned"]),
                 others=round(measured.others, 3), seconds=measured.seconds(), rays_written=rays["exact"],
                 rays_planned=rays["planned"])


def mesh_trials(scene: Scene, yardstick: Yardstick, pixels: np.ndarray) -> list[MeshTrial]:
    """Mitsuba on finer and finer meshes, for information, until one is as good on `pixels` (h, w, bool), or fails."""
    trials: list[MeshTrial] = []
    with TemporaryDirectory(prefix="raytruth-plan-") as folder, Pool(1) as pool:
        store = RunStore(Path(folder))
        for resolution in MESHES:
            trials.append(_mesh_trial(scene, resolution, store, pool, yardstick, pixels))
            if trials[-1].state != "ok" or trials[-1].over == 0:
                break
    return trials


def _mesh_trial(scene: Scene, resolution: int, store: RunStore, pool: Pool, yardstick: Yardstick,
           pixels: np.ndarray) -> MeshTrial:
    run = store.make(Request(scene, "mitsuba-mesh", {"resolution": resolution}), pool, MESH_LIMIT)
    if run.state != "ok":
        return MeshTrial(resolution=resolution, state=run.state, message=run.message)
    change = yardstick.from_truth(store.planes(run, scene)["color"])
    difference = yardstick.difference(change, pixels, 32)  # bits: Mitsuba's
    return MeshTrial(resolution=resolution, state="ok", over=difference.over, largest=difference.largest,
                     build=run.timing.build, warm=run.timing.warm)
