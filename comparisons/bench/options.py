"""What a user may choose about a run of the benchmark."""

from __future__ import annotations

import math
from dataclasses import dataclass

from reference_tracer.scene import library
from reference_tracer.scene.model import Scene

from .results import Clock


@dataclass(frozen=True)
class Options:
    turns: int = 5
    size: str | None = None  # "640x480", or "own" for the scenes'; None: what the group finds enough
    clock: Clock | None = None  # None: wall time on a quiet machine
    budget: float = 120.0  # seconds a row's turns may take
    quick: bool = False  # smaller pictures

    def sized(self, name: str, most_rays: int) -> Scene:
        """The shipped scene `name`, shrunk to at most `most_rays` camera rays (quick: a quarter of them)."""
        scene = library.scene(name)
        if self.size == "own":
            return scene
        if self.size:
            return scene.resized(*map(int, self.size.split("x")))
        width, height = scene.camera.width, scene.camera.height
        most = most_rays / 4 if self.quick else most_rays
        scale = min(1.0, math.sqrt(most / (width * height)) / scene.tracing.samples)
        return scene.resized(max(1, round(scale * width)), max(1, round(scale * height)))


def picture(scene: Scene) -> str:
    """The size of the scene's picture in words."""
    samples = scene.tracing.samples
    return (f"{scene.camera.width} x {scene.camera.height}"
            + (f", {samples} x {samples} samples" if samples > 1 else ""))
