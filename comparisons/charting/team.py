"""The child processes that measure: one a kind of renderer, started when first asked, replaced after a crash."""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from reference_tracer.scene.model import Scene

from ..process import Worker
from .sweeps import Contestant

Answer = dict  # see Worker.ask


def started(kernels: Path) -> Worker:
    return Worker([sys.executable, "-m", "comparisons.charting.worker", str(kernels)])


@dataclass
class Team:
    """Asks one process at a time, so that nothing that is timed has company. `limit` is in seconds, of one answer."""

    limit: float
    threads: int | None = None
    start: Callable[[Path], Worker] = started
    _workers: dict[str, Worker] = field(default_factory=dict)

    def __enter__(self) -> Team:
        self._kernels = Path(tempfile.mkdtemp(prefix="raytruth-kernels-"))
        return self

    def __exit__(self, *_) -> None:
        for worker in self._workers.values():
            worker.close()
        shutil.rmtree(self._kernels, ignore_errors=True)

    def truth(self, scene: Scene, path: Path) -> Answer:
        """Made in a process of its own, whose kernels nobody finds compiled."""
        return self._ask("truth", {"do": "truth", "scene": _text(scene), "truth": str(path)})

    def first(self, id: str, scene: Scene, contestant: Contestant, planes: Path, truth: Path | None = None,
              threads: int | None = None) -> Answer:
        """Makes the picture that is judged."""
        return self._about("first", id, scene, contestant, truth, threads, planes=str(planes))

    def timed(self, id: str, scene: Scene, contestant: Contestant, truth: Path | None = None,
              threads: int | None = None, hits: bool = True) -> Answer:
        """One turn."""
        return self._about("timed", id, scene, contestant, truth, threads, hits=hits)

    def _about(self, do: str, id: str, scene: Scene, contestant: Contestant, truth: Path | None, threads: int | None,
               **more) -> Answer:
        return self._ask(contestant.process, {
            "do": do, "id": id, "scene": _text(scene), "renderer": contestant.renderer, "settings": contestant.settings,
            "timed": contestant.timed, "truth": str(truth) if truth else None, "threads": threads or self.threads,
            **more})

    def _ask(self, process: str, request: dict) -> Answer:
        if process not in self._workers:
            self._workers[process] = self.start(self._kernels / process)
        return self._workers[process].ask(request, self.limit)


def _text(scene: Scene) -> str:
    return scene.model_dump_json(by_alias=True)
