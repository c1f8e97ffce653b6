"""The worst pixels of every comparison, each followed through both renderers ray by ray, on the scene itself.

A comparison that differs, as a fault or as its nature, has up to ten of them followed; one that agrees, where there is less
to explain, three. Only the chosen pixels are traced, which takes the reference little; but Mitsuba converts the scene anew for
it. Where Mitsuba agrees it is not asked, and what its picture tells of the first hit has to do.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from raytruth.reference_tracer.scene.load import parse_scene
from raytruth.reference_tracer.scene.model import Scene
from raytruth.reference_tracer.tracer.image_files import load_npz
from raytruth.reference_tracer.tracer.render import Picture

from .. import meshes, renderers
from ..document import Record
from ..execution import store
from ..execution.pool import Pool, Task, complete
from ..results import Comparison, Run, Verdict
from ..suites import reader
from .document import State, WorstPixel
from .measure import Tracer, followed, of_renderer

FOLDER = "histories"
SECONDS = 300.0  # of one comparison; a Mitsuba scene is converted anew
MOST = {"agrees": 3, "differs": 10, "expected": 10}  # pixels of a comparison


class Followed(Record):
    """What a worker finds."""

    state: State
    message: str = ""
    pixels: list[WorstPixel] = []


def with_histories(comparisons: Sequence[Comparison], scenes: Sequence[Scene], runs: dict[str, Run], folder: Path,
                   pool: Pool) -> list[Comparison]:
    """The comparisons with the rays of their worst pixels, as far as these could be traced."""
    by_name = {scene.name: scene for scene in scenes}
    tasks = {c.id: _task(by_name[c.scene], runs[c.reference], runs[c.test], c.verdict, c.worst[:MOST[c.verdict]], folder)
             for c in comparisons if c.worst and c.verdict in MOST}
    found = complete(tasks.values(), store.Store(folder, FOLDER), pool, Followed.model_validate_json,
                     reader(Followed, "history"))
    return [c.model_copy(update={"histories": found[tasks[c.id].key].pixels}) if c.id in tasks else c for c in comparisons]


def _task(scene: Scene, reference: Run, test: Run, verdict: Verdict, worst: list[dict], folder: Path) -> Task:
    places = [(int(pixel["row"]), int(pixel["col"]), float(pixel["error"])) for pixel in worst]
    code = [name for run in (reference, test) for name in renderers.find(run.renderer).code]
    thorough = verdict != "agrees"
    return Task(store.key(reference.key, test.key, places, thorough, made_by=(__name__, *code)),
                f"rays: {scene.name}, {test.renderer}", f"{__name__}:answer", {
        "scene": scene.model_dump_json(by_alias=True), "renderers": [reference.renderer, test.renderer], "places": places,
        "thorough": thorough, "results": str(folder),
        "planes": [str(folder / run.planes) for run in (reference, test)]}, SECONDS, "attribution")


def answer(request: dict) -> dict:
    """In a worker: the rays of some pixels in two renderers."""
    meshes.keep_in(Path(request["results"]))
    scene = parse_scene(request["scene"].encode(), "scene")
    pictures = [Picture(scene=scene, **load_npz(path)[0]) for path in request["planes"]]
    tracers = [_tracer(name, request["thorough"]) for name in request["renderers"]]
    pixels = followed(*tracers, *pictures, [tuple(place) for place in request["places"]])
    return {"state": "ok", "pixels": [pixel.model_dump(mode="json") for pixel in pixels]}


def _tracer(name: str, thorough: bool) -> Tracer:
    renderer = renderers.find(name)
    if thorough or renderer.module == "reference":
        return of_renderer(name)
    return Tracer(renderer.title, lambda scene: renderers.render(name, scene))
