"""The parent's side of a worker: asks, waits with a time limit, and starts a new one when it died.

A worker leads a process group of its own. Whatever it started dies with it: no renderer outlives its case.
"""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import signal
import subprocess
import time
from collections.abc import Callable

LONGEST_ANSWER = 1 << 20  # bytes
LAST_WORDS = 4096  # bytes kept of what a worker says on stderr
LONGEST_MESSAGE = 500  # characters
PIECE = 1 << 16
STATES = ("ok", "crashed", "refused", "missing", "unwritable")


class Worker:
    """A child process, started when first asked and replaced after a crash or a timeout."""

    noun = "the renderer's process"
    started_with: dict = {}  # what subprocess.Popen is told beside

    def __init__(self, command: list[str], environment: dict[str, str] | None = None):
        self.command, self.environment = command, environment
        self._process: subprocess.Popen | None = None
        self._said = b""
        self._stopped = False

    def ask(self, request: dict, limit: float, told: Callable[[str, float], None] = lambda label, share: None) -> dict:
        """The worker's answer; or {"state": "crashed" | "timeout" | "malformed", "message": ...}, never an exception.

        `limit` is in seconds. `told` is called with what the worker says of its progress.
        """
        try:
            self._start()
            line = self._exchange(json.dumps({**request, "asker": os.getpid()}).encode() + b"\n", limit, told)
        except TimeoutError:
            self.close()
            return {"state": "timeout", "message": f"gave no answer within {limit:g} s"}
        except OSError as error:  # it died before it had read the request, or could not even be started
            if self._process is None:
                return {"state": "crashed", "message": f"{self.noun} could not be started ({error.strerror})"}
            line = b""
        if b"\n" not in line:
            return {"state": "crashed", "message": self._obituary(line)}
        try:
            answer = json.loads(line)
            if answer["state"] not in STATES or not isinstance(answer.get("facts", {}), dict):
                raise ValueError
            return {**answer, "message": str(answer.get("message", ""))[:LONGEST_MESSAGE]}
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            self.close()
            return {"state": "malformed", "message": f"answered {_text(line[:80])!r}, which is not an answer"}

    def close(self) -> None:
        """Ends the process and all it started."""
        if self._process:
            self._kill()
            self._process.wait()
            for pipe in (self._process.stdin, self._process.stdout, self._process.stderr):
                with contextlib.suppress(OSError):  # what was written last may find nobody left to read it
                    pipe.close()
            self._process = None

    def stop(self) -> None:
        """Ends the process for good, from another thread: whoever waits for its answer learns that it died."""
        self._stopped = True
        with contextlib.suppress(AttributeError):  # the other thread has just closed it
            self._kill()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _start(self) -> None:
        if self._process and not self._ended() and self._is_silent():
            return
        self.close()
        self._said = b""
        self._process = subprocess.Popen(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                         stderr=subprocess.PIPE, bufsize=0, process_group=0, env=self.environment,
                                         **self.started_with)
        for pipe in (self._process.stdin, self._process.stdout, self._process.stderr):
            os.set_blocking(pipe.fileno(), False)
        if self._stopped:
            self._kill()

    def _is_silent(self) -> bool:
        """Whether stdout is open and empty: a second answer to the last request must not be taken for the next one's."""
        try:
            os.read(self._process.stdout.fileno(), PIECE)
        except BlockingIOError:
            return True
        return False

    def _kill(self) -> None:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)

    def _ended(self) -> bool:
        """Whether the process has ended. It is not reaped: its id stays taken, so that its group can still be killed."""
        return os.waitid(os.P_PID, self._process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None

    def _look_after(self) -> None:
        """Called again and again while an answer is waited for."""

    def _exchange(self, request: bytes, limit: float, told: Callable[[str, float], None],
                  whole: Callable[[bytes], bool] = lambda said: b"\n" in said or len(said) > LONGEST_ANSWER) -> bytes:
        """Sends `request`; what comes back, as soon as it is `whole`, the process ended or closed its output.

        Both ways piecewise: a worker that reads nothing, or whose line never ends, must time out too. What it says on
        stderr is read on the way, so that it cannot block on a full pipe, and all but the last words are forgotten.
        """
        process, deadline, line = self._process, time.monotonic() + limit, b""
        with selectors.DefaultSelector() as selector:
            selector.register(process.stdin, selectors.EVENT_WRITE)
            selector.register(process.stdout, selectors.EVENT_READ)
            selector.register(process.stderr, selectors.EVENT_READ)
            while True:
                ended = self._ended()  # before reading: what it wrote until then is read below
                ready = [key.fileobj for key, _ in selector.select(0 if ended else 0.25)]
                if process.stdin in ready:
                    request = request[os.write(process.stdin.fileno(), request[:PIECE]):]
                    if not request:
                        selector.unregister(process.stdin)
                if process.stderr in ready and not self._listen():
                    selector.unregister(process.stderr)
                if process.stdout in ready:
                    piece = os.read(process.stdout.fileno(), PIECE)
                    line = _after_progress(line + piece, told)
                    if not piece or whole(line):
                        return line
                elif ended:  # a child of it may hold the pipe open
                    return line
                self._look_after()
                if time.monotonic() > deadline:
                    raise TimeoutError

    def _listen(self) -> bool:
        """Reads a piece of stderr; whether there may be more."""
        try:
            piece = os.read(self._process.stderr.fileno(), PIECE)
        except BlockingIOError:
            return False
        self._said = (self._said + piece)[-LAST_WORDS:]
        return bool(piece)

    def _obituary(self, line: bytes) -> str:
        if len(line) > LONGEST_ANSWER:
            self.close()
            return f"{self.noun} answered more than {LONGEST_ANSWER >> 10} KiB"
        patience = time.monotonic() + 2
        while not self._ended() and time.monotonic() < patience:
            time.sleep(0.02)
        ended, pieces = self._ended(), 0
        while self._listen() and pieces < 100:  # a child of it may go on talking
            pieces += 1
        process = self._process
        self.close()
        if not ended:
            how = "closed its output"
        elif process.returncode < 0:
            how = f"was killed by {_signal_name(-process.returncode)}"
        else:
            how = f"ended with exit code {process.returncode}"
        said = [words for line in _text(self._said).splitlines() if (words := line.strip())]
        return f"{self.noun} {how}" + (f"; its last words: {said[-1][:300]}" if said else "")


def _after_progress(said: bytes, told: Callable[[str, float], None]) -> bytes:
    """What is left of `said` after the lines that tell of progress."""
    while said.startswith(b'{"share"') and b"\n" in said:
        line, said = said.split(b"\n", 1)
        with contextlib.suppress(ValueError, KeyError, TypeError):
            progress = json.loads(line)
            told(str(progress["label"])[:LONGEST_MESSAGE], float(progress["share"]))
    return said


def _text(piece: bytes) -> str:
    return piece.decode(errors="replace")


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:  # a real-time signal
        return f"signal {number}"
