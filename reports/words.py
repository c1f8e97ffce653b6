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
    "differs": Verdict("differs", "Differs", "At least one measured number exceeds its limit, and nothing known explains it."),
    "not compared": Verdict("absent", "Not compared",
                            "There is no picture to compare: the renderer failed, is not installed, or cannot express the scene."),
    "expected": Verdict("expected", "Differs as expected",
                        "The pictures differ, for a reason that is known, stated, and no fault of the test side."),
    "agrees": Verdict("agrees", "Agrees", "Every measured number keeps its limit."),
}

STATES = {  # worst first
    "crashed": "Crashed: the program ended with an error",
    "timeout": "Timed out: the program was stopped at its time limit",
    "malformed": "Malformed: the program ended normally, but what it wrote is no picture",
    "missing": "Missing: the program is not installed on this machine",
    "refused": "Refused: the program cannot express this scene, and says why",
}

TRUTHS = {
    "model": ("the model’s truth", "The reference side is the model’s truth: the document’s model of light with exact "
              "intersections, no surface missed. Every other renderer is held against it."),
    "algorithm": ("the algorithm’s truth", "The reference side is the algorithm’s truth: the document’s method to the "
                  "letter, its own misses included. A port that follows the document line by line is held against it."),
}

LITERAL = ("The test side is a truth as well, of another kind: the document’s method to the letter, which walks along "
           "the ray in fixed steps and starts Newton’s method in the middle of one. What differs here is what those steps "
           "miss, and is the method’s own, not a defect of the program.")

_METRICS = {
    "max": ("largest error", "the largest difference of any channel of any pixel"),
    "p99": ("99th percentile", "99 % of the pixels differ by less"),
    "p50": ("median", "half of the pixels differ by less"),
    "mean": ("mean error", "the mean difference"),
    "mse": ("MSE", "mean squared error; 0 is equality"),
    "rmse": ("RMSE", "square root of the mean squared error; 0 is equality"),
    "psnr": ("PSNR", "peak signal-to-noise ratio, in decibels: the higher the closer; 48 is one 8-bit level"),
    "ssim": ("SSIM", "structural similarity; 1 is equality"),
    "flip": ("FLIP", "mean difference as a viewer sees it when flipping between the pictures; 0 is equality"),
}


@dataclass(frozen=True)
class Metric:
    label: str
    means: str


def metric(name: str) -> Metric:
    """The words for a metric's name; a name that is not known stands for itself."""
    label, means = _METRICS.get(name.lower(), (name.replace("_", " "), ""))
    return Metric(label, means)


def truth_sentences(against: str, test: Run) -> list[str]:
    """What kind of truth a comparison's reference is, and its test side if that is one too."""
    return [TRUTHS[against][1]] + ([LITERAL] if against == "model" and is_literal(test) else [])


def is_literal(run: Run) -> bool:
    return run.renderer == "paper"
