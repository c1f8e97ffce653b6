"""The pool's tasks on many machines: an engine on Dask distributed, which stands in for `Pool`.

On every machine `dask worker ADDRESS --nthreads 1`, in an environment that has raytruth with its extra `cluster`, and with
the folder of results at the same path. A Dask worker makes its tasks in a child process, like the local pool: a renderer
that crashes, hangs or keeps memory costs that child. What Dask carries is the name of a case and its small answer; planes go
through the folder.

A worker that is lost has its cases made by another; a scheduler that is started anew is given what has no answer yet.
"""

from __future__ import annotations

import asyncio
import threading
import time
import uuid
from collections import Counter, OrderedDict
from collections.abc import Iterable, Iterator

from raytruth.reference_tracer.errors import InputError, MissingError

from .machine import source_hash
from .pool import COMMAND, Pool, Progress, Silent, Task
from .process import Worker
from .store import UnwritableError

KEPT = 2  # children that a thread of a worker keeps, by their processes: what they have compiled is there for the next case
PATIENCE = 60.0  # seconds in which a scheduler that is gone may come back
TRIES = 2  # Dask gives a case up when some workers (allowed-failures) were lost over it: others may have ended them
_own = threading.local()


class Cluster:
    """Makes tasks wherever the workers of the scheduler at `address` are. Raises InputError where it does not answer."""

    def __init__(self, address: str, progress: Progress | None = None):
        try:
            import distributed
        except ImportError:
            raise MissingError("--cluster needs Dask; install it with 'pip install raytruth[cluster]'") from None
        self._dask, self.address, self.progress = distributed, address, progress or Silent()
        self._client = None
        self._connect(3.0)

    def run(self, tasks: Iterable[Task]) -> Iterator[tuple[Task, dict]]:
        """As `Pool.run`."""
        unanswered, lost = dict.fromkeys(tasks), Counter()
        self.progress.expect(len(unanswered))
        while unanswered:
            try:
                for task, answer in self._answers(list(unanswered), lost):
                    del unanswered[task]
                    self.progress.end(task.label, answer.pop("seconds", 0.0), answer["state"])
                    if answer["state"] == "unwritable":
                        raise UnwritableError(answer["message"])
                    if answer["state"] == "misfit":
                        raise InputError(f"--cluster {self.address}: {answer['message']}")
                    yield task, answer
            except _SchedulerLost:
                self._connect(PATIENCE)

    def ask(self, task: Task) -> dict:
        """The answer to one task."""
        return next(answer for _, answer in self.run([task]))

    def close(self) -> None:
        """Gives back what is under way; the workers stay."""
        if self._client:
            self._client.close(timeout=5)
            self._client = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _connect(self, patience: float) -> None:
        self.close()
        deadline = time.monotonic() + patience
        while True:
            try:
                asyncio.run(self._knock())
                self._client = self._dask.Client(self.address, timeout=2, set_as_default=False)
                return
            except (OSError, ValueError, AssertionError) as error:  # TimeoutError is an OSError; ValueError: no address at all
                busy = isinstance(error, AssertionError)  # Dask gives its own thread 10 seconds to begin
                if isinstance(error, ValueError) or time.monotonic() > deadline + PATIENCE * busy:
                    raise InputError(f"--cluster {self.address}: no Dask scheduler answers there; start one with "
                                     "'dask scheduler'") from None
                time.sleep(0.5)

    async def _knock(self) -> None:
        """Raises OSError or ValueError where nobody answers; a Client that finds nobody complains again when it is freed."""
        comm = await self._dask.comm.connect(self.address, timeout=2,
                                             **self._dask.Security().get_connection_args("client"))
        await comm.close()

    def _answers(self, tasks: list[Task], lost: Counter) -> Iterator[tuple[Task, dict]]:
        """Raises _SchedulerLost."""
        run, of = uuid.uuid4().hex, {}

        def submit(task: Task):
            request = {"function": task.function, "arguments": task.arguments, "limit": task.limit, "process": task.process,
                       "source": source_hash()}
            future = self._client.submit(make, request, key=f"{task.label} {task.key} {run} {lost[task]}", pure=False)
            of[future] = task
            return future

        try:
            done = self._dask.as_completed([submit(task) for task in tasks], loop=self._client.loop)
            for future in done:
                task = of.pop(future)
                if future.status not in ("finished", "error"):
                    raise _SchedulerLost
                answer, gone = None, future.exception() if future.status == "error" else None
                try:
                    answer = None if gone else future.result()
                except self._dask.KilledWorker as error:  # an answer may be lost after its case has ended, with its worker
                    gone = error
                if answer is not None:
                    yield task, answer
                else:
                    lost[task] += 1
                    if lost[task] < TRIES:
                        done.add(submit(task))
                    else:
                        message = f"its workers were lost, again and again: {gone}"
                        yield task, {"state": "crashed", "message": message[:500]}
                future.release()
        except (OSError, self._dask.CancelledError, self._dask.comm.CommClosedError):
            raise _SchedulerLost from None


def engine(jobs: int, progress: Progress | None = None, cluster: str | None = None) -> Pool | Cluster:
    """What makes tasks: `jobs` processes of this machine, or the workers of the Dask scheduler at the address `cluster`."""
    return Cluster(cluster, progress) if cluster else Pool(jobs, progress)


class _SchedulerLost(Exception):
    pass


def make(request: dict) -> dict:
    """In a Dask worker: the answer of a child process, with the seconds that it took."""
    if request["source"] != source_hash():
        return {"state": "misfit", "message": "a worker runs another raytruth than this one; install the same on all machines"}
    children = _own.__dict__.setdefault("children", OrderedDict())
    process = request["process"]
    if process not in children:
        children[process] = Worker(list(COMMAND))
    children.move_to_end(process)
    while len(children) > KEPT:
        children.popitem(last=False)[1].close()
    start = time.monotonic()
    answer = children[process].ask({"function": request["function"], "arguments": request["arguments"]}, request["limit"])
    return {**answer, "seconds": time.monotonic() - start}
