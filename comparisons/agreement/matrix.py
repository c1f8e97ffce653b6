"""The matrix of a suite's runs: every pair on every scene, who is missing and why, and who is the odd one out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from reference_tracer.scene import library
from reference_tracer.scene.model import Scene

from .. import renderers
from ..results import Run
from ..runs import Request, RunStore
from .majority import odd_ones
from .pairs import pairs
from .records import Absent, Dissent, Matrix, Member, Pair, Place, Tightness

LITERAL = "paper"
WORDS = {"missing": "is not installed", "refused": "cannot express the scene", "crashed": "crashed",
         "timeout": "ran out of time", "malformed": "wrote what is no picture"}


def matrix(scenes: Sequence[Scene], names: Sequence[str], runs: dict[str, Run], store: RunStore, *, jobs: int = 2,
           tightness: Sequence[Tightness] = (), done: Callable[[], None] = lambda: None) -> Matrix:
    """The matrix of the renderers `names` on `scenes`, all of whose `runs` (by key) have been made.

    `done` is called after every scene. Pairs are kept in the store: what was measured before is not measured again.
    """
    of_scene = {scene.name: [runs[Request(scene, name).key] for name in names] for scene in scenes}

    def measure(scene: Scene) -> list[Pair]:
        found = pairs(scene, of_scene[scene.name], store)
        done()
        return found

    with ThreadPoolExecutor(jobs) as pool:
        measured = list(pool.map(measure, scenes))
    members = [Member(name=name, title=renderers.find(name).title, implementation=renderers.find(name).module)
               for name in names]
    absent = [Absent(scene=scene.name, renderer=run.renderer, state=run.state,
                     reason=f"{WORDS[run.state]}: {run.message}")
              for scene in scenes for run in of_scene[scene.name] if run.state != "ok"]
    places = [Place(name=s.name, title=s.title or s.name, pixels=s.camera.width * s.camera.height,
                    effect=s.name in library.effects()) for s in scenes]
    return Matrix(members=members, places=places, pairs=[pair for found in measured for pair in found], absent=absent,
                  dissent=[d for scene, found in zip(scenes, measured) for d in dissent(scene, members, of_scene, found)],
                  tightness=list(tightness), command="raytruth compare")


def dissent(scene: Scene, members: list[Member], of_scene: dict[str, list[Run]], found: list[Pair]) -> list[Dissent]:
    """The renderers that the majority on `scene` contradicts."""
    present = {run.renderer for run in of_scene[scene.name] if run.state == "ok"}
    broken = {frozenset((p.first, p.second)): p for p in found if not p.agrees}
    told = []
    for odd in odd_ones({m.name: m.implementation for m in members if m.name in present}, map(tuple, broken), LITERAL):
        example = max((p for pair, p in broken.items() if pair & set(odd.suspects)), key=lambda p: p.color_p99 or 0)
        expected = LITERAL in odd.suspects
        told.append(Dissent(scene=scene.name, renderers=list(odd.suspects), against=list(odd.against), expected=expected,
                            sentence=_sentence(odd, example, expected)))
    return told


def _sentence(odd, example: Pair, expected: bool) -> str:
    numbers = f"between {example.first} and {example.second} {example.broken}"
    if len(odd.suspects) > 1:
        return f"no majority tells which of {_listed(odd.suspects)} is wrong; {numbers}"
    return f"{odd.suspects[0]} disagrees with {_listed(odd.against)}; {numbers}" + (
        "; what falls between two of its steps is missed, which is its nature and not a fault" if expected else "")


def _listed(names: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
