"""The matrix of a suite's runs: every pair on every scene, who is missing and why, and who is the odd one out."""

from __future__ import annotations

from collections.abc import Sequence

from raytruth.reference_tracer.scene import library
from raytruth.reference_tracer.scene.model import Scene

from .. import renderers
from ..results import Comparison, Run
from ..runs import Request
from ..verdicts.judge import judge, literal
from ..verdicts.majority import Odd, odd_ones, stages_of
from ..verdicts.pairs import Measurements
from ..verdicts.pairs import Pair as Pictures
from ..verdicts.tolerances import between, unproven
from .records import Absent, Dissent, Matrix, Member, Pair, Place, Tightness

WORDS = {"missing": "is not installed", "refused": "cannot express the scene", "crashed": "crashed",
         "timeout": "ran out of time", "malformed": "wrote what is no picture"}


def matrix(scenes: Sequence[Scene], names: dict[str, tuple[str, ...]], runs: dict[str, Run], pairs: Sequence[Pictures],
           measurements: Measurements, comparisons: Sequence[Comparison], tightness: Sequence[Tightness] = ()) -> Matrix:
    """The matrix of the renderers that `names` has for `scenes`, all of whose `runs` (by key) have been made, from `pairs`.

    Who differs from the truth as its nature is, by `comparisons`, has no vote on that scene.
    """
    of_scene = {scene.name: [runs[Request(renderers.nearest(scene, name).scene, name).key] for name in names[scene.name]]
                for scene in scenes}
    written = {scene.name: scene for scene in scenes}
    natural = {(c.scene, runs[c.test].renderer) for c in comparisons if c.verdict == "expected"}
    measured = {scene.name: [_pair(p, written[scene.name], measurements, natural) for p in pairs
                             if p.scene.name == scene.name]
                for scene in scenes}
    members = [Member(name=name, title=renderers.find(name).title, implementation=renderers.find(name).module)
               for name in dict.fromkeys(name for scene in scenes for name in names[scene.name])]
    absent = [Absent(scene=scene.name, renderer=run.renderer, state=run.state,
                     reason=f"{WORDS[run.state]}: {run.message}")
              for scene in scenes for run in of_scene[scene.name] if run.state != "ok"]
    places = [Place(name=s.name, title=s.title or s.name, pixels=s.camera.width * s.camera.height,
                    effect=s.name in library.effects()) for s in scenes]
    return Matrix(members=members, places=places, absent=absent,
                  pairs=[pair for found in measured.values() for pair in found],
                  dissent=[d for scene in scenes for d in dissent(scene, of_scene[scene.name], measured[scene.name])],
                  tightness=list(tightness), command="raytruth compare")


def _pair(pictures: Pictures, written: Scene, measurements: Measurements, natural: set[tuple[str, str]]) -> Pair:
    first, second, found = pictures.first, pictures.second, measurements.of(pictures)
    tolerance, m = between(first, second), found.metrics
    if found.state != "ok":
        verdict, reason = "differs", f"measuring {found.state}: {found.message}"
    elif pictures.literal:
        verdict, reason = literal(m, pictures.scene.tracing.step_size)[:2]
    else:
        verdict, reason = judge(m, tolerance, between(first, second, exact=True))[:2]
    instead = renderers.nearest(written, first.renderer, second.renderer).words
    reason += f"; compared with {instead}" if instead else ""
    return Pair(scene=pictures.scene.name, first=first.renderer, second=second.renderer, agrees=verdict == "agrees",
                expected=verdict != "agrees" and any((pictures.scene.name, run.renderer) in natural
                                                     for run in (first, second)),
                tolerance=tolerance.name, instead=instead, broken="" if verdict == "agrees" else reason,
                color_p99=m.get("color p99"), color_max=m.get("color max"),
                inner_max=m.get("inner max"), failing=m.get("failing pixels"),
                mismatches=m.get("object mismatches"), depth_p99=m.get("depth p99"))


def dissent(scene: Scene, runs: Sequence[Run], found: Sequence[Pair]) -> list[Dissent]:
    """Who the majority on `scene` contradicts, of all that have a vote; then who differs as its nature is, or as the scene that
    it was given may."""
    told = []
    voters = {run.renderer: stages_of(run, renderers.find(run.renderer).module) for run in runs if run.state == "ok"}
    for pair in (broken := [p for p in found if not p.agrees and p.expected]):
        natural = pair.second if pair.first == runs[0].renderer else pair.first
        if voters.pop(natural, None) is not None:
            others = [p.second if p.first == natural else p.first for p in broken if natural in (p.first, p.second)]
            told.append(Dissent(scene=scene.name, renderers=[natural], against=others, expected=True, sentence=(
                f"{natural} disagrees with {_listed(others)}; between {pair.first} and {pair.second} {pair.broken}; its "
                "oracle shows the same: its nature, not a fault; the causes stand with the comparison")))
    for run in runs:  # who may have been given another scene
        mine = [p for p in found if not p.agrees and not p.expected and run.renderer in (p.first, p.second)]
        if mine and (why := unproven(run)) and voters.pop(run.renderer, None) is not None:
            others = [p.second if p.first == run.renderer else p.first for p in mine]
            told.append(Dissent(scene=scene.name, renderers=[run.renderer], against=others, expected=True, sentence=(
                f"{run.renderer} disagrees with {_listed(others)}; between {mine[0].first} and {mine[0].second} "
                f"{mine[0].broken}; it has no vote: {why}")))
    counted = {frozenset((p.first, p.second)): p for p in found if not p.agrees and {p.first, p.second} <= voters.keys()}
    if odd := odd_ones(voters, map(tuple, counted)):
        example = max((p for pair, p in counted.items() if pair & set(odd.suspects)), key=lambda p: p.color_p99 or 0)
        told.insert(0, Dissent(scene=scene.name, renderers=list(odd.suspects), against=list(odd.against),
                               stages=list(odd.stages), split=odd.split, expected=False, sentence=_sentence(odd, example)))
    return told


def _sentence(odd: Odd, example: Pair) -> str:
    numbers = f"between {example.first} and {example.second} {example.broken}"
    if odd.split:
        return f"no majority tells which of {_listed(odd.suspects)} is wrong; {numbers}"
    together = f", which share {_listed(odd.stages)}," if len(odd.suspects) > 1 else ""
    return f"{_listed(odd.suspects)}{together} disagree{'' if together else 's'} with {_listed(odd.against)}; {numbers}"


def _listed(names: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
