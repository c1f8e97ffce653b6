"""Names the first stage at which two renderers part on a scene."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from reference_tracer.tracer.render import Picture
from reference_tracer.scene.model import Scene

from .asked import Asked
from .camera import explanation
from .history import of_planes, triple
from .records import STAGES, Attribution, Evidence, History, Stage, WorstPixel
from .side import Side, of_function
from .stages import ASK, Finding

WORST, APART = 3, 12  # pixels followed, and how far they lie from each other at least
TURNABLE = ("hit", "root", "normal", "shading", "shadow")  # what a turned picture may be taken for
MEANS: dict[Stage, str] = {
    "camera": "the rays that leave the camera (section 2)", "hit": "what a ray hits first (sections 4.1 and 4.2)",
    "root": "where it hits (section 4.2)", "normal": "the normal there (decision N1)",
    "shading": "the light that falls on a point, without shadows (section 4.3.1)",
    "shadow": "shadow rays (section 4.3.1, decision L3)", "reflection": "reflection rays (section 4.3.2)",
    "refraction": "refraction rays and total reflection (section 4.3.3)",
    "mixing": "the sum of the three colours (section 4.3.4)", "sampling": "the mean of a pixel's samples (section 5)"}


def attribute(scene: Scene, a: Callable[[Scene], Picture], b: Callable[[Scene], Picture], *,
              progress: Callable[[str], None] = lambda stage: None) -> Attribution:
    """Asks both renderers stage by stage, up to the first that diverges.

    `a` and `b` are functions that make the picture of a scene, or Sides, whose rays can be followed. What rounding
    explains (see `bounds`) never counts. Raises whatever the renderers raise.
    """
    a, b = of_function(a, "the first renderer"), of_function(b, "the second renderer")
    asked, evidence, explained, named = Asked(a, b), [], None, None
    for stage in STAGES:
        if named:
            evidence.append(Evidence(stage=stage, outcome="not asked"))
            continue
        progress(stage)
        entry, finding, explained = _asked(stage, asked, scene, explained)
        if finding and stage in TURNABLE and (words := explanation(asked, finding.pair, finding.mask)):
            evidence[0] = _evidence("camera", finding, [finding.question], diverges=True)
            evidence += [Evidence(stage=later, outcome="not asked") for later in STAGES[len(evidence):]]
            return _attribution(scene, a, b, "camera", finding, words, evidence)
        evidence.append(entry)
        named = finding and (stage, finding)
    stage, finding = named or (None, None)
    return _attribution(scene, a, b, stage, finding, finding.detail if finding else "", evidence)


def _asked(stage: Stage, asked: Asked, scene: Scene, explained) -> tuple[Evidence, Finding | None, np.ndarray]:
    """What a stage shows: its evidence, the finding that diverges if one does, and the pixels explained by now."""
    findings = []
    strays = explained
    for finding in ASK[stage](asked, scene):
        mask = finding.mask
        if strays is not None and mask.shape == strays.shape:
            mask = mask & ~strays
        if finding.pair.significant(mask):
            finding = Finding(finding.question, finding.pair, mask, finding.error, finding.unit, finding.detail)
            return _evidence(stage, finding, [finding.question], diverges=True), finding, explained
        findings.append(Finding(finding.question, finding.pair, mask, finding.error, finding.unit))
    for finding in findings:
        if explained is None:
            explained = finding.mask
        elif finding.mask.shape == explained.shape:
            explained = explained | finding.mask
    if not findings:
        return Evidence(stage=stage, outcome="not asked"), None, explained
    questions = list(dict.fromkeys(f.question for f in findings))
    worst = max(findings, key=lambda f: int(f.mask.sum()))
    return _evidence(stage, worst, questions, diverges=False), None, explained


def _evidence(stage: Stage, finding: Finding, questions: list[str], diverges: bool) -> Evidence:
    count = int(finding.mask.sum())
    largest = float(finding.error[finding.mask].max()) if count else None
    return Evidence(stage=stage, questions=questions, outcome="diverges" if diverges else "agrees",
                    pixels=int(finding.pair.bound.decided.sum()), diverging=count, largest=largest, unit=finding.unit)


def _attribution(scene: Scene, a: Side, b: Side, stage: Stage | None, finding: Finding | None, detail: str,
                 evidence: list[Evidence]) -> Attribution:
    about = {"scene": scene.name, "a": a.title, "b": b.title, "width": scene.camera.width, "height": scene.camera.height,
             "evidence": evidence}
    if stage is None:
        return Attribution(**about, stage=None, sentence="No stage diverges: on every derived scene the two are as near "
                           "to each other as their precision allows")
    found = evidence[STAGES.index(stage)]
    agree = [e.stage for e in evidence[:STAGES.index(stage)] if e.outcome == "agrees"]
    before = f"; {_list(agree)} {'agrees' if len(agree) == 1 else 'agree'}" if agree else ""
    sentence = (f"They part at {stage}, {MEANS[stage]}: {detail + ': ' if detail else ''}{found.diverging} of "
                f"{found.pixels} pixels ({finding.question}), by up to {found.largest:.2g} ({finding.unit}){before}")
    return Attribution(**about, stage=stage, sentence=sentence, shown_on=finding.question,
                       pixels=_worst(finding, a, b))


def _history(side: Side, picture: Picture, row: int, col: int) -> History:
    return side.rays(picture.scene, row, col) if side.rays else of_planes(picture, row, col, side.title)


def _list(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _worst(finding: Finding, a: Side, b: Side) -> list[WorstPixel]:
    """The diverging pixels of largest error, apart from each other, their rays followed on both sides."""
    error = np.where(finding.mask, finding.error, -1.0)
    pair, pixels = finding.pair, []
    while len(pixels) < WORST and error.max() >= 0:
        row, col = (int(k) for k in np.unravel_index(np.argmax(error), error.shape))
        pixels.append(WorstPixel(
            row=row, col=col, difference=float(finding.error[row, col]), color_a=triple(pair.a.color[row, col]),
            color_b=triple(pair.b.color[row, col]), a=_history(a, pair.a, row, col), b=_history(b, pair.b, row, col)))
        error[max(0, row - APART):row + APART + 1, max(0, col - APART):col + APART + 1] = -1
    return pixels
