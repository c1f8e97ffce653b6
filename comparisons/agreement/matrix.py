"""The matrix of a suite's runs: every pair on every scene, who is missing and why, and who is the odd one out."""

from __future__ import annotations

from collections.abc import Sequence

from reference_tracer.scene import library
from reference_tracer.scene.model import Scene

from .. import renderers
from ..results import Run
from ..runs import Request
from ..verdicts.majority import odd_ones
from ..verdicts.judge import between, judge
from ..verdicts.pairs import Measurements
from ..verdicts.pairs import Pair as Pictures
from .records import Absent, Dissent, Matrix, Member, Pair, Place, Tightness

LITERAL = "paper"
WORDS = {"missing": "is not installed", "refused": "cannot express the scene", "crashed": "crashed",
         "timeout": "ran out of time", "malformed": "wrote what is no picture"}


def matrix(scenes: Sequence[Scene], names: Sequence[str], runs: dict[str, Run], pairs: Sequence[Pictures],
           measurements: Measurements, tightness: Sequence[Tightness] = ()) -> Matrix:
    """The matrix of the renderers `names` on `scenes`, all of whose `runs` (by key) have been made, from all `pairs`."""
    of_scene = {scene.name: [runs[Request(scene, name).key] for name in names] for scene in scenes}
    measured = {scene.name: [_pair(p, measurements) for p in pairs if p.scene.name == scene.name] for scene in scenes}
    members = [Member(name=name, title=renderers.find(name).title, implementation=renderers.find(name).module)
               for name in names]
    absent = [Absent(scene=scene.name, renderer=run.renderer, state=run.state,
                     reason=f"{WORDS[run.state]}: {run.message}")
              for scene in scenes for run in of_scene[scene.name] if run.state != "ok"]
    places = [Place(name=s.name, title=s.title or s.name, pixels=s.camera.width * s.camera.height,
                    effect=s.name in library.effects()) for s in scenes]
    return Matrix(members=members, places=places, pairs=[pair for found in measured.values() for pair in found], absent=absent,
                  dissent=[d for scene in scenes for d in dissent(scene, members, of_scene, measured[scene.name])],
                  tightness=list(tightness), command="raytruth compare")


def _pair(pictures: Pictures, measurements: Measurements) -> Pair:
    first, second, found = pictures.first, pictures.second, measurements.of(pictures)
    tolerance, m = between(first, second), found.metrics
    verdict, reason = judge(m, tolerance)[:2] if found.state == "ok" else (
        "differs", f"measuring {found.state}: {found.message}")
    return Pair(scene=pictures.scene.name, first=first.renderer, second=second.renderer, agrees=verdict == "agrees",
                tolerance=tolerance.name, broken="" if verdict == "agrees" else reason, color_p99=m.get("color p99"),
                color_max=m.get("color max"), inner_max=m.get("inner max"), failing=m.get("failing pixels"),
                mismatches=m.get("object mismatches"), depth_p99=m.get("depth p99"))


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
