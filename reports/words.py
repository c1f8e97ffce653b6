"""What the terms of a results document mean, in words; the report explains each where it uses it."""

from __future__ import annotations

from dataclasses import dataclass

from comparisons.results import Run


@dataclass(frozen=True)
class Verdict:
    """A verdict's style (shape and colour), short word, and meaning."""

    style: str
    word: str
    means: str


VERDICTS = {  # worst first
    "differs": Verdict("differs", "Differs",
                       "At least one measured number exceeds its limit, and nothing known explains it."),
    "not compared": Verdict("absent", "Not compared",
                            "There is no picture to compare: the renderer failed, is not installed, or cannot express "
                            "the scene."),
    "expected": Verdict("expected", "Differs as expected",
                        "The pictures differ, for a reason that is known, stated, and no fault of the test side."),
    "agrees": Verdict("agrees", "Agrees", "Every measured number keeps its limit."),
}

@dataclass(frozen=True)
class State:
    """Why a run has no picture."""

    word: str
    means: str
    is_fault: bool


STATES = {  # worst first
    "crashed": State("Crashed", "the program ended with an error", True),
    "timeout": State("Timed out", "the program was stopped at its time limit", True),
    "malformed": State("Malformed", "the program ended normally, but what it wrote is no picture", True),
    "missing": State("Missing", "the program is not installed on this machine", False),
    "refused": State("Refused", "the program cannot express this scene, and says why", False),
}

TRUTHS = {
    "model": ("the model’s truth", "The reference side is the model’s truth: the document’s model of light with exact "
              "intersections, no surface missed. Every other renderer is held against it."),
    "algorithm": ("the algorithm’s truth", "The reference side is the algorithm’s truth: the document’s method to the "
                  "letter, its own misses included. A port that follows the document line by line is held against it."),
}

LITERAL = ("The test side is a truth as well, of another kind: the document’s method to the letter, which walks along "
           "the ray in fixed steps and starts Newton’s method in the middle of one. What differs here is what those "
           "steps miss, and is the method’s own, not a defect of the program.")

KEY_METRICS = ("object mismatches", "failing pixels", "color max")  # what to show of a comparison without gates

_METRICS = {
    "pixels": "all pixels of the picture",
    "interior pixels": "those away from silhouettes: one object all around, and no ray that grazes it",
    "hit pixels": "those whose centre’s ray hits something in the reference",
    "hit/miss mismatches": "pixels that hit something on one side only",
    "object mismatches": "pixels where another object, or none, was hit",
    "interior mismatches": "the same, counted away from silhouettes only",
    "depth p99": "99 % of the interior pixels have a smaller relative error of depth",
    "depth max": "the largest relative error of depth of an interior pixel",
    "normal p99 degrees": "99 % of the interior pixels have normals closer than this",
    "normal max degrees": "the largest angle between normals of an interior pixel",
    "not finite": "pixels with a channel that is NaN or infinite",
    "color max": "the largest difference of any linear channel of any pixel",
    "color p99": "99 % of the pixels differ by less",
    "color mean": "the mean over the pixels",
    "failing pixels": "pixels off by more than 1/255, one step of an 8-bit picture",
    "clustered failing pixels": "failing pixels whose eight neighbours fail too: a region, not an edge",
    "mse": "mean squared error; 0 is equality",
    "psnr": "peak signal-to-noise ratio in decibels; higher is closer, 48 is one 8-bit step everywhere",
    "ssim": "structural similarity; 1 is equality",
    "flip mean": "what a viewer sees when flipping between the pictures; 0 is nothing",
}


@dataclass(frozen=True)
class Metric:
    label: str
    means: str


def metric(name: str) -> Metric:
    """The words for a metric's name; a name that is not known stands for itself."""
    return Metric(name.replace("_", " ").replace("color", "colour"), _METRICS.get(name.lower(), ""))


def sentence(text: str) -> str:
    """`text` with a capital at its beginning and a full stop at its end."""
    text = text.strip()
    return capital(text) + ("" if not text or text[-1] in ".!?" else ".")


def capital(text: str) -> str:
    """`text` with a capital at its beginning, the rest as it is."""
    return text[:1].upper() + text[1:]


def truth_sentences(against: str, test: Run) -> list[str]:
    """What kind of truth a comparison's reference is, and its test side if that is one too."""
    return [TRUTHS[against][1]] + ([LITERAL] if against == "model" and is_literal(test) else [])


def is_literal(run: Run) -> bool:
    return run.renderer == "paper"
