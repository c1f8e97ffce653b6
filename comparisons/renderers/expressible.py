"""The nearest scene that a renderer can express: the same one, with the switches that it lacks at their defaults.

No scene loses its oracle to a switch: what a renderer cannot express is taken out of both pictures. The truth that it is
held against is then the truth of that nearest scene, and every verdict says so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from raytruth.reference_tracer.scene.model import EFFECTS, Scene, Tracing


@dataclass(frozen=True)
class Lack:
    """A parameter of `tracing` that a renderer cannot express in full.

    `nearest` takes a value to one that it can express, the value itself where it can; `words` tell what then is so, and
    why.
    """

    parameter: str
    words: str
    nearest: Callable[[Any], Any]


@dataclass(frozen=True)
class Nearest:
    """A scene, and what of the one that was asked for is otherwise: "" for nothing."""

    scene: Scene
    words: str = ""


def _default(parameter: str, words: str) -> Lack:
    return Lack(parameter, words, lambda value: getattr(Tracing(), parameter))


def _with_effects(needed: set[str], words: str) -> Lack:
    return Lack("effects", words, lambda asked: asked if needed <= set(asked) else tuple(
        e for e in EFFECTS if e in needed or e in asked))


SNELL = _default("refraction", "Snell's law, because {} refracts by no other")
SAMPLED = (_default("cutoff", "no cutoff, because {} leaves no ray out for its weight"),
           _default("adaptive", "every sample, because {} takes as many everywhere"))
MITSUBA = (SNELL, *SAMPLED, _with_effects(set(EFFECTS), "all secondary rays, because {} traces every kind"))
EMBREE = (SNELL, *SAMPLED)
POVRAY = (_default("lights", "lights added up, because {} adds lights"),
          _default("range", "a range for each ray, because {} ends all rays at one distance"), SNELL, *SAMPLED,
          _with_effects({"reflection", "refraction"}, "reflection and refraction rays, because {} traces both"))


def nearest(scene: Scene, lacks: Iterable[tuple[str, tuple[Lack, ...]]]) -> Nearest:
    """The scene nearest to `scene` that everybody can express; `lacks` are (renderer in a word, what it lacks) pairs."""
    changes, words = {}, []
    for who, lack in ((who, lack) for who, those in lacks for lack in those):
        asked = getattr(scene.tracing, lack.parameter)
        if lack.parameter not in changes and (found := lack.nearest(asked)) != asked:
            changes[lack.parameter] = found
            words.append(lack.words.format(who))
    return Nearest(scene.traced_with(**changes), "; ".join(words)) if changes else Nearest(scene)
