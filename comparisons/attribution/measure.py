"""Names the first stage at which two renderers part on a scene, and finds out who notices faults made on purpose."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from raytruth.reference_tracer import llvm
from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.render import Picture, Renderer

from .. import document, meshes, renderers
from ..execution import pool as pools
from ..execution import store
from ..execution.cluster import engine
from ..execution.pool import Pool, Progress
from ..renderers import RENDERERS
from ..suites import reader
from ..verdicts import conditioning
from ..verdicts.metrics import worst_pixels
from ..verdicts.pictures import verdict_on
from . import cases, rays
from .cases import FAULTS, Fault
from .document import (
    COMMAND,
    FILE,
    STAGES,
    Answer,
    Attribution,
    Evidence,
    History,
    Judged,
    Judgement,
    Stage,
    Table,
    WorstPixel,
    WrongOnPurpose,
)
from .stages import COMPARE, Finding, Pictures, camera_fault

WORST = 3  # pixels followed
TURNABLE = ("hit", "root", "normal", "shading", "shadow")  # what a turned picture may be taken for
MEANS: dict[Stage, str] = {
    "camera": "the rays that leave the camera (section 2)", "hit": "what a ray hits first (sections 4.1 and 4.2)",
    "root": "where it hits (section 4.2)", "normal": "the normal there (decision N1)",
    "shading": "the light that falls on a point, without shadows (section 4.3.1)",
    "shadow": "shadow rays (section 4.3.1, decision L3)", "reflection": "reflection rays (section 4.3.2)",
    "refraction": "refraction rays and total reflection (section 4.3.3)",
    "mixing": "the sum of the three colours (section 4.3.4)", "sampling": "the mean of a pixel's samples (section 5)"}
FOLDER = "attributions"
SECONDS = 600.0  # of one attribution
JUDGES = ("mitsuba-native", "povray")  # renderers that share no tracing with the reference
WIDTH, HEIGHT = 240, 180  # of the pictures in which they look for faults


@dataclass(frozen=True)
class Tracer:
    """One of the two renderers: called with a scene it makes the picture, and it tells a pixel's rays if it can."""

    title: str
    make: Callable[[Scene], Picture]
    rays: Callable[[Scene, list[tuple[int, int]]], list[History]] | None = None  # of pixels (row, col); None: not told

    def __call__(self, scene: Scene) -> Picture:
        return self.make(scene)

    def histories(self, picture: Picture, places: list[tuple[int, int]]) -> list[History]:
        if self.rays and places:
            return self.rays(picture.scene, places)
        return [rays.of_planes(picture, row, col, self.title) for row, col in places]


def of_renderer(name: str) -> Tracer:
    """A renderer of the suite. Raises InputError for an unknown one."""
    renderer = renderers.find(name)
    settings, follow = {**renderer.settings, "repeat": False}, None
    if renderer.module == "reference":
        follow = lambda scene, places: rays.ours(Renderer(scene, settings["method"]), places, renderer.title)
    elif renderer.module == "mitsuba":
        from . import mitsuba_rays  # Mitsuba is imported only where it is used

        settings["require_native"] = False  # a derived scene may have none of the native shapes that its scene has
        follow = lambda scene, places: mitsuba_rays.rays(scene, places, renderer.title, settings["shapes"],
                                                         settings["resolution"])
    else:
        settings = renderer.settings
    return Tracer(renderer.title, lambda scene: renderers.render(name, scene, settings), follow)


def of_fault(id: str) -> Tracer:
    """The reference tracer with a fault made on purpose, or as it is if `id` is empty. Raises InputError."""
    if not id:
        return of_renderer("exact")
    fault = cases.fault(id)
    title = f"reference, wrong on purpose: {fault.title}"
    renderer = lambda scene: Renderer(scene, world=fault.world)
    return Tracer(title, lambda scene: renderer(scene).picture(),
                  lambda scene, places: rays.ours(renderer(scene), places, title))


def attribute(scene: Scene, a: Callable[[Scene], Picture], b: Callable[[Scene], Picture], *,
              progress: Callable[[str], None] = lambda stage: None) -> Attribution:
    """Compares both renderers stage by stage, up to the first that diverges.

    `a` and `b` are functions that make the picture of a scene, or Tracers, whose rays can be followed. What rounding
    explains (see `bounds`) never counts. Raises whatever the renderers raise.
    """
    a, b = (r if isinstance(r, Tracer) else Tracer(f"the {nth} renderer", r) for r, nth in ((a, "first"), (b, "second")))
    pictures, evidence, explained, named = Pictures(a, b), [], None, None
    for stage in STAGES:
        if named:
            evidence.append(Evidence(stage=stage, outcome="not asked"))
            continue
        progress(stage)
        entry, finding, explained = _examined(stage, pictures, scene, explained)
        evidence.append(entry)
        named = finding and (stage, finding)
        if finding and stage in TURNABLE and (detail := camera_fault(pictures, finding.pair, finding.mask)):
            evidence[0] = _evidence("camera", finding, [finding.question], diverges=True)
            evidence[-1] = Evidence(stage=stage, outcome="not asked")
            named = "camera", replace(finding, detail=detail)
    about = {"scene": scene.name, "a": a.title, "b": b.title, "width": scene.camera.width, "height": scene.camera.height,
             "evidence": evidence}
    if named is None:
        return Attribution(**about, stage=None, sentence="No stage diverges: on every derived scene the two are as near "
                           "to each other as their precision allows")
    stage, finding = named
    return Attribution(**about, stage=stage, sentence=_sentence(stage, finding, evidence), shown_on=finding.question,
                       pixels=_worst(finding, a, b))


def _examined(stage: Stage, pictures: Pictures, scene: Scene,
              explained: np.ndarray | None) -> tuple[Evidence, Finding | None, np.ndarray | None]:
    """What a stage shows: its evidence, the finding that diverges if one does, and the pixels explained by now."""
    findings = []
    known = lambda mask: explained is not None and explained.shape == mask.shape
    for finding in COMPARE[stage](pictures, scene):
        finding = replace(finding, mask=finding.mask & ~explained if known(finding.mask) else finding.mask)
        if finding.pair.significant(finding.mask):
            return _evidence(stage, finding, [finding.question], diverges=True), finding, explained
        findings.append(finding)
    if not findings:
        return Evidence(stage=stage, outcome="not asked"), None, explained
    for finding in findings:
        if explained is None or known(finding.mask):
            explained = finding.mask if explained is None else explained | finding.mask
    worst = max(findings, key=lambda f: int(f.mask.sum()))
    questions = list(dict.fromkeys(f.question for f in findings))
    return _evidence(stage, worst, questions, diverges=False), None, explained


def _evidence(stage: Stage, finding: Finding, questions: list[str], diverges: bool) -> Evidence:
    count = int(finding.mask.sum())
    largest = float(finding.error[finding.mask].max()) if count else None
    return Evidence(stage=stage, questions=questions, outcome="diverges" if diverges else "agrees",
                    pixels=int(finding.pair.bound.decided.sum()), diverging=count, largest=largest, unit=finding.unit)


def _sentence(stage: Stage, finding: Finding, evidence: list[Evidence]) -> str:
    found, earlier = evidence[STAGES.index(stage)], evidence[:STAGES.index(stage)]
    agree = [e.stage for e in earlier if e.outcome == "agrees"]
    before = ""
    if agree:
        listed = " and ".join(filter(None, (", ".join(agree[:-1]), agree[-1])))
        before = f"; {listed} {'agrees' if len(agree) == 1 else 'agree'}"
    return (f"They part at {stage}, {MEANS[stage]}: {finding.detail + ': ' if finding.detail else ''}{found.diverging} of "
            f"{found.pixels} pixels ({finding.question}), by up to {found.largest:.2g} ({finding.unit}){before}")


def _worst(finding: Finding, a: Tracer, b: Tracer) -> list[WorstPixel]:
    """The diverging pixels of largest error, one a cluster, their rays followed through both renderers."""
    worst = worst_pixels(np.where(finding.mask, finding.error, 0.0), WORST)
    return followed(a, b, finding.pair.a, finding.pair.b, [(p["row"], p["col"], p["error"]) for p in worst])


def followed(a: Tracer, b: Tracer, picture_a: Picture, picture_b: Picture,
             places: list[tuple[int, int, float]]) -> list[WorstPixel]:
    """Pixels (row, col, difference) of two pictures of one scene, with their rays in both renderers."""
    pixels = [(row, col) for row, col, _ in places]
    return [WorstPixel(row=row, col=col, difference=difference, color_a=picture_a.color[row, col].tolist(),
                       color_b=picture_b.color[row, col].tolist(), a=of_a, b=of_b)
            for (row, col, difference), of_a, of_b in zip(places, a.histories(picture_a, pixels),
                                                          b.histories(picture_b, pixels))]


@dataclass(frozen=True)
class Task:
    """Two renderers on a scene. With a `fault` ("" for none), the second is the reference with it, whatever `b` says."""

    scene: Scene
    a: str
    b: str = "exact"
    fault: str | None = None

    @cached_property
    def key(self) -> str:
        both = [renderers.find(name) for name in (self.a, self.b)]
        return store.key(self.scene.hash, [renderer.content for renderer in both], self.fault,
                         made_by=(__name__, *(name for renderer in both for name in renderer.code)))


def make_all(tasks: Sequence[Task], folder: Path, pool: Pool, limit: float = SECONDS) -> dict[Task, Answer]:
    """Every task, finished ones from `folder`; `limit` is in seconds for one. Nothing is raised for a failure."""
    found = pools.complete([pools.Task(task.key, f"attribution: {task.scene.name}, {task.fault or task.b}",
                                       f"{__name__}:answer", {
        "scene": task.scene.model_dump_json(by_alias=True), "a": task.a, "b": task.b, "fault": task.fault,
        "results": str(folder)},
        limit, "attribution") for task in tasks], store.Store(folder, FOLDER), pool, Answer.model_validate_json,
        reader(Answer, "attribution"))
    return {task: found[task.key] for task in tasks}


def answer(request: dict) -> dict:
    """In a worker: the attribution of two renderers on a scene, and whether their comparison differs."""
    llvm.narrow_kernels()  # each derived scene has kernels of its own, for one small picture
    meshes.keep_in(Path(request["results"]))
    scene = parse_scene(request["scene"].encode(), "scene")
    a = of_renderer(request["a"])
    b = of_renderer(request["b"]) if request["fault"] is None else of_fault(request["fault"])
    found, reason = None, ""
    if request["fault"] is not None:
        kept = store.Store(Path(request["results"]), conditioning.FOLDER)
        verdict, reason, _ = verdict_on(scene, request["a"], a(scene), b(scene), kept)
        found = verdict == "differs"
    judged = Judged(found=found, reason=reason, attribution=attribute(scene, a, b))
    return {"state": "ok", "judged": judged.model_dump(mode="json")}


def wrong_on_purpose(folder: Path, *, jobs: int = 2, progress: Progress | None = None,
                     cluster: str | None = None) -> Table:
    """Puts every fault, and none, before every judge, and writes attribution.json into `folder`."""
    judges = [name for name in JUDGES if name in RENDERERS]
    rows = {(f.id, f.effect): f for f in FAULTS.values()} | {("", effect): None for effect in library.effects()}
    tasks = {(id, effect, judge): Task(library.scene(effect).resized(WIDTH, HEIGHT), judge, fault=id)
             for id, effect in rows for judge in judges}
    with engine(jobs, progress, cluster) as pool:
        answers = make_all(list(tasks.values()), folder, pool)
    table = Table(width=WIDTH, height=HEIGHT, command=COMMAND, rows=[
        _row(f, effect, [_judgement(judge, answers[tasks[id, effect, judge]]) for judge in judges])
        for (id, effect), f in rows.items()])
    return document.keep(table, folder / FILE, COMMAND)


def _row(f: Fault | None, effect: str, judgements: list[Judgement]) -> WrongOnPurpose:
    if f is None:
        return WrongOnPurpose(id="right", title="the tracer as it is", effect=effect, right="", wrong="", expected=None,
                              because="nothing is wrong: nothing may be found", judgements=judgements)
    return WrongOnPurpose(id=f.id, title=f.title, effect=effect, right=f.right, wrong=f.wrong, expected=f.stage,
                          because=f.because, judgements=judgements)


def _judgement(name: str, answer: Answer) -> Judgement:
    return Judgement(renderer=name, title=RENDERERS[name].title, state=answer.state, message=answer.message,
                     **(vars(answer.judged) if answer.judged else {}))
