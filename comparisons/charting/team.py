"""Who is asked to measure: the pool's processes, one a kind of renderer, which last so that recordings are replayed."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from reference_tracer.scene.model import Scene

from ..execution.pool import Pool, Task
from .sweeps import Contestant

Answer = dict  # see Worker.ask


@dataclass
class Team:
    """Where nothing is timed, two are asked at a time; else one. `limit` is in seconds, of one answer."""

    limit: float
    threads: int | None = None

    def __enter__(self) -> Team:
        self._folder, self._pool = Path(tempfile.mkdtemp(prefix="raytruth-chart-")), Pool(2, lasting=True)
        return self

    def __exit__(self, *_) -> None:
        self._pool.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def planes(self, id: str) -> Path:
        """Where the picture called `id` is put until it is judged."""
        return self._folder / f"{id}.npz"

    def truth(self, scene: Scene, path: Path) -> Answer:
        """Made in a process of its own, whose kernels nobody finds compiled."""
        return self._pool.ask(self._task("truth", "truth", {"do": "truth", "scene": _text(scene), "truth": str(path)}))

    def firsts(self, scene: Scene, contestants: dict[str, Contestant], truth: Path | None = None,
               threads: int | None = None) -> dict[str, Answer]:
        """Makes the pictures that are judged, by the ids of their contestants; they are left at `planes`."""
        tasks = [self._of("first", id, scene, contestant, truth, threads, planes=str(self.planes(id)))
                 for id, contestant in contestants.items()]
        return {task.key: answer for task, answer in self._pool.run(tasks)}

    def timed(self, id: str, scene: Scene, contestant: Contestant, truth: Path | None = None,
              threads: int | None = None, hits: bool = True) -> Answer:
        """One turn."""
        return self._pool.ask(self._of("timed", id, scene, contestant, truth, threads, hits=hits))

    def _of(self, do: str, id: str, scene: Scene, contestant: Contestant, truth: Path | None, threads: int | None,
            **more) -> Task:
        return self._task(id, contestant.process, {
            "do": do, "id": id, "scene": _text(scene), "renderer": contestant.renderer, "settings": contestant.settings,
            "timed": contestant.timed, "truth": str(truth) if truth else None, "threads": threads or self.threads, **more})

    def _task(self, id: str, process: str, arguments: dict) -> Task:
        return Task(id, id, "comparisons.charting.worker:answer", {**arguments, "kernels": str(self._folder / process)},
                    self.limit, process)


def _text(scene: Scene) -> str:
    return scene.model_dump_json(by_alias=True)
