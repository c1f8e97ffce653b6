"""What the rays of a picture meet: objects, generations, distances."""

from __future__ import annotations

import numpy as np

from reference_tracer.tracer.render import Watch, render
from reference_tracer.scene.model import Scene


class Seen(Watch):
    """Notes what every ray of some pixels (h, w, bool) meets."""

    def __init__(self, scene: Scene, pixels: np.ndarray):
        self.pixels = pixels.ravel()
        self.objects = np.zeros(len(scene.objects) + 1, bool)
        self.farthest = 0.0
        self.generations = 0
        render(scene, "exact", watch=self)

    def begin(self, world, first, count):
        self.first = first

    def observe(self, wave, interaction):
        slot = wave.slot.numpy().astype(np.int64) + self.first
        counts = (wave.weight.numpy() > 0) & self.pixels[np.minimum(slot, len(self.pixels) - 1)]
        index = interaction.hit.index.numpy()[counts]
        if not index.size:
            return
        self.objects |= np.bincount(index, minlength=len(self.objects)) > 0
        self.generations = max(self.generations, wave.generation)
        hit = index < len(self.objects) - 1
        self.farthest = max(self.farthest, float(interaction.hit.t.numpy()[counts][hit].max(initial=0.0)))

    def met(self, k: int) -> bool:
        """Whether any ray hits object `k`."""
        return bool(self.objects[k])
