"""One pool for all suites: tasks made in processes of their own, several at a time, told as they end.

A pool is asked by `run`, with tasks that name their key, and answers small dicts; whatever is large goes through the
store, as files. So an engine that spreads tasks over many machines with a common folder can stand in for `Pool`: see
cluster.py.
"""

from __future__ import annotations

import os
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from queue import SimpleQueue
from threading import Thread
from typing import Protocol, TypeVar

from .process import Worker
from .store import Store, UnwritableError

COMMAND = (sys.executable, "-P", "-m", "raytruth.comparisons.execution.worker")  # no modules of the folder it is in
Record = TypeVar("Record")


class Progress(Protocol):
    """Whoever is told how far the work is."""

    def expect(self, cases: int) -> None:
        """So many more cases are to come."""

    def begin(self, label: str, share: float = 0.0) -> None:
        """A case has been begun, or is done to that share. Called from any thread."""

    def end(self, label: str, seconds: float, state: str) -> None:
        """A case has ended."""


class Silent:
    """Tells nobody."""

    def expect(self, cases: int) -> None: ...
    def begin(self, label: str, share: float = 0.0) -> None: ...
    def end(self, label: str, seconds: float, state: str) -> None: ...


@dataclass(frozen=True, eq=False)
class Task:
    """A case to be made: `function` ("module:function") is called with `arguments`, in a worker, within `limit` seconds.

    Tasks of one `process` share processes, so that what one compiles is found by the next and no other's fault touches
    them. `label` is what is told of it.
    """

    key: str
    label: str
    function: str
    arguments: dict
    limit: float
    process: str = ""


class Pool:
    """Makes up to `jobs` tasks at the same time.

    `lasting` processes are kept until the pool is closed, one of a name, so that a later task finds what an earlier one
    has left in them; others end when no task waits for them. `environment` holds variables for the processes.
    """

    def __init__(self, jobs: int = 2, progress: Progress | None = None, *, lasting: bool = False,
                 environment: dict[str, str] | None = None):
        self.jobs, self.progress, self.lasting = jobs, progress or Silent(), lasting
        self._environment = {**os.environ, **environment} if environment else None
        self._idle: dict[str, list[Worker]] = defaultdict(list)
        self._busy: dict[Task, tuple[Worker, Thread, float]] = {}
        self._answers: SimpleQueue[tuple[Task, dict]] = SimpleQueue()

    def run(self, tasks: Iterable[Task]) -> Iterator[tuple[Task, dict]]:
        """Every task with its answer, in the order in which they end. An answer has a `state`, and a `message` if that is
        not "ok"; nothing is raised for a task that fails, but UnwritableError where the folder of results is full."""
        waiting = list(tasks)
        self.progress.expect(len(waiting))
        while waiting or self._busy:
            while len(self._busy) < self.jobs and (task := self._next(waiting)):
                self._start(task)
            task, answer = self._answers.get()
            worker, thread, began = self._busy.pop(task)
            thread.join()
            self._idle[task.process].append(worker)
            self._dismiss({other.process for other in waiting})
            self.progress.end(task.label, time.monotonic() - began, answer["state"])
            if answer["state"] == "unwritable":
                raise UnwritableError(answer["message"])
            yield task, answer

    def ask(self, task: Task) -> dict:
        """The answer to one task."""
        return next(answer for _, answer in self.run([task]))

    def close(self) -> None:
        """Ends all processes and whatever they have started; a task under way is lost."""
        for worker, _, _ in self._busy.values():
            worker.stop()
        for _, thread, _ in self._busy.values():
            thread.join(5)
        for worker in [w for w, _, _ in self._busy.values()] + [w for idle in self._idle.values() for w in idle]:
            worker.close()
        self._busy.clear()
        self._idle.clear()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _next(self, waiting: list[Task]) -> Task | None:
        """Takes the first task that may begin."""
        taken = {task.process for task in self._busy} if self.lasting else set()
        task = next((t for t in waiting if t.process not in taken), None)
        if task:
            waiting.remove(task)
        return task

    def _start(self, task: Task) -> None:
        worker = self._idle[task.process].pop() if self._idle[task.process] else Worker(list(COMMAND), self._environment)
        thread = Thread(target=self._ask, args=(task, worker), daemon=True)
        self._busy[task] = worker, thread, time.monotonic()
        self.progress.begin(task.label)
        thread.start()

    def _ask(self, task: Task, worker: Worker) -> None:
        try:
            answer = worker.ask({"function": task.function, "arguments": task.arguments}, task.limit,
                                lambda label, share: self.progress.begin(f"{task.label}: {label}", share))
        except Exception as error:  # or whoever waits would wait for ever
            answer = {"state": "crashed", "message": f"{type(error).__name__}: {error}"}
        self._answers.put((task, answer))

    def _dismiss(self, wanted: set[str]) -> None:
        if not self.lasting:
            for process in [name for name in self._idle if name not in wanted]:
                for worker in self._idle.pop(process):
                    worker.close()


def complete(tasks: Iterable[Task], store: Store, pool: Pool, read: Callable[[str], Record],
             settle: Callable[[Task, dict], Record], arrays: bool = False) -> dict[str, Record]:
    """The record of every task by its key: from the store, by `read`; or made, by `settle` of its answer, and kept.

    With `arrays`, the task has put some where the store keeps them.
    """
    tasks = list({task.key: task for task in tasks}.values())
    records = {task.key: found for task in tasks if (found := store.find(task.key, read)) is not None}
    missing = [task for task in tasks if task.key not in records]
    for task in missing:
        store.forget(task.key)
    for task, answer in pool.run(missing):
        records[task.key] = settle(task, answer)
        if not store.keep(task.key, records[task.key], arrays):
            store.forget(task.key)
    return {task.key: records[task.key] for task in tasks}
