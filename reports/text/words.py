"""What the terms of a results document mean; the report explains each where it uses it."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass

from .numbers import powers

LONGEST_NAME = 80


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
                            "There is nothing to judge: no picture, because the renderer failed, is not installed, or "
                            "cannot express the scene; or one that proves nothing, for the reason beside it."),
    "expected": Verdict("expected", "Differs as expected",
                        "The pictures differ, for a reason that is known and stated, and is no fault of the renderer."),
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
    "model": "The reference is the model’s truth: the document’s model of light with exact intersections, no surface "
             "missed. Every other renderer is held against it.",
    "algorithm": "The reference is the algorithm’s truth: the document’s method to the letter, its own misses included. "
                 "A port that follows the document line by line is held against it.",
}

LITERAL = ("The renderer under test is a truth as well, of another kind: the document’s method to the letter, which walks "
           "along the ray in fixed steps and starts Newton’s method in the middle of one.")

KEY_METRICS = ("object mismatches", "failing pixels", "color max")  # what to show of a comparison without gates

METRICS = {
    "pixels": "all pixels of the picture",
    "interior pixels": "those away from silhouettes: one object all around, and no ray that grazes it",
    "hit pixels": "those whose centre’s ray hits something in the reference",
    "hit/miss mismatches": "pixels that hit something in one picture only",
    "object mismatches": "pixels where another object, or none, was hit",
    "interior mismatches": "the same, counted away from silhouettes only",
    "depth p99": "99 % of the interior pixels have a smaller relative error of depth",
    "depth max": "the largest relative error of depth of an interior pixel",
    "normal p99 degrees": "99 % of the interior pixels have normals closer than this",
    "normal max degrees": "the largest angle between normals of an interior pixel",
    "pixels at risk": "pixels that the reference itself shows differently when rays and surfaces move as far as they may",
    "displaced pixels": "those of whose rays some meet a mesh or a grid",
    "exact pixels": "those whose rays meet exact shapes alone",
    "exact hit pixels": "the same where the reference hits something, away from edges",
    "oracle pixels": "those that the recursive oracle was asked for",
    "pixels unlike exact": "pixels on which the literal method and exact intersections differ",
    "pixels unlike exact, asked": "those of them that the oracle was asked for",
    "not finite": "pixels with a channel that is NaN or infinite",
    "color max": "the largest difference of any linear channel of any pixel",
    "color p99": "99 % of all pixels compared differ by less",
    "color mean": "the mean over all pixels compared",
    "failing pixels": "pixels off by more than 1/255, one step of an 8-bit picture",
    "clustered failing pixels": "failing pixels whose eight neighbours fail too: a region, not an edge",
    "mse": "mean squared error; 0 is equality",
    "psnr": "peak signal-to-noise ratio in decibels; higher is closer, 48 is one 8-bit step everywhere",
    "ssim": "structural similarity; 1 is equality",
    "flip mean": "what a viewer sees when flipping between the pictures; 0 is nothing",
}


GLOSSARY = {
    "99 % of all pixels within x": "sort the differences of all pixels of a picture, background included: 99 of 100 are at "
                                   "most x. Where only some pixels are meant, the page says which",
    "channel": "red, green or blue. Values are linear: 1 is full white, one step of an 8-bit picture is 1/255",
    "cluster": "pixels less than 13 rows and columns apart; of each cluster the worst pixel alone is listed",
    "depth": "the distance t from the camera along the ray through the pixel’s centre; its error is relative to t",
    "interior pixel": "a pixel whose eight neighbours see the same object, and whose ray meets it at a cosine above 0.2",
    "largest difference": "the maximum over all channels of all pixels",
    "limit of a pixel": "how far its colour may be from the truth’s, by the precision of the renderer and the error of its "
                        "surfaces; measured by disturbing the reference’s own rays (raytruth sensitivity)",
    "literal method": "the document’s root search to the letter: fixed steps, then Newton’s method from the middle of a step",
    "pixel off by more than 1/255": "a pixel one of whose channels differs by more than one step of an 8-bit picture",
    "proven": "followed from interval arithmetic or an exact computation; nothing sampled is called so",
    "sampled": "checked on chosen rays, pixels or perturbations: what was not chosen may differ",
    "truth": "the reference with exact intersections; where it cannot decide a ray, it says undecided",
    "undecided": "rounding does not allow to say what the ray hits; such pixels judge nobody",
    "warm picture": "the second one in a row: everything is compiled and converted",
}


@dataclass(frozen=True)
class Metric:
    label: str
    means: str


def metric(name: str) -> Metric:
    """The words for a metric's name; a name that is not known stands for itself."""
    return Metric(name.replace("_", " ").replace("color", "colour"), METRICS.get(name.lower(), ""))


def full_stop(text: str) -> str:
    """`text` with a full stop at its end, its powers raised; it begins as it is written, with the name of a function say."""
    text = powers(text.strip())
    return text + ("" if not text or text[-1] in ".!?" else ".")


def sentence(text: str) -> str:
    """`text` with a capital at its beginning and a full stop at its end."""
    return capital(full_stop(text))


def capital(text: str) -> str:
    """`text` with a capital at its beginning, the rest as it is."""
    return text[:1].upper() + text[1:]


def count(number: int, one: str, many: str = "") -> str:
    """The number with its noun: 1 scene, 2 scenes."""
    return f"{number} {one if number == 1 else many or one + 's'}"


def slug(text: str) -> str:
    """A name for files and anchors, made from an untrusted text: safe on every file system, the same on every rebuild.

    `text` itself if it is a plain name already; else what is plain of it, and a hash that keeps it apart.
    """
    plain = re.sub(r"[^a-z0-9-]+", "-", text.lower()).strip("-")[:LONGEST_NAME].strip("-")
    if plain and plain == text:
        return plain
    return f"{plain}-{hashlib.sha256(text.encode('utf-8', 'surrogatepass')).hexdigest()[:8]}".lstrip("-")
