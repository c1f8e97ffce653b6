"""Finished measurements, kept by all that can change them: the machine and the number of turns among it."""

from __future__ import annotations

from pathlib import Path

from reference_tracer.scene.model import Scene

from ..execution import store
from ..execution.machine import machine
from ..renderers import RENDERERS
from .results import FOLDER


class ChartStore(store.Store):
    """The folder `chart/` of a results folder."""

    def __init__(self, folder: Path, turns: int):
        super().__init__(folder, FOLDER)
        here = machine()
        self._always = [turns, here.processor, here.cores]

    def key(self, scene: Scene, *content, renderer: str = "") -> str:
        """`renderer` is who is measured; ours, if it is none of the suite's."""
        found = RENDERERS.get(renderer)
        return store.key(scene.hash, *content, self._always, found.content if found else renderer,
                         made_by=("comparisons.charting.worker", "comparisons.charting.measuring",
                                  *(found.code if found else ())))
