"""The parent's side of a worker: asks, waits with a time limit, and starts a new one when it died."""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import signal
import subprocess
import sys
import tempfile
import time


LONGEST_ANSWER = 1 << 20  # bytes


class Worker:
    """One renderer's child process, started when first asked and replaced after a crash or a timeout."""

    def __init__(self, command: list[str] | None = None):
        self.command = command or [sys.executable, "-m", "comparisons.worker"]
        self._process: subprocess.Popen | None = None
        self._errors = None

    def ask(self, request: dict, limit: float) -> dict:
        """The worker's answer; or {"state": "crashed" | "timeout" | "malformed", "message": ...}, never an exception.

        `limit` is in seconds.
        """
        try:
            self._start()
            self._process.stdin.write(json.dumps(request) + "\n")
            self._process.stdin.flush()
            line = self._read_line(limit)
        except TimeoutError:
            self.close()
            return {"state": "timeout", "message": f"gave no answer within {limit:g} s"}
        except OSError:
            line = ""
        if not line:
            return {"state": "crashed", "message": self._obituary()}
        try:
            answer = json.loads(line)
            if answer["state"] not in ("ok", "crashed", "refused", "missing"):
                raise ValueError
            return answer
        except (ValueError, KeyError, TypeError):
            self.close()
            return {"state": "malformed", "message": f"answered {line[:80]!r}, which is not an answer"}

    def close(self) -> None:
        if self._process:
            self._process.kill()
            self._process.wait()
            self._process.stdin.close()
            self._process.stdout.close()
            self._errors.close()
            self._process = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _start(self) -> None:
        if self._process and self._process.poll() is None:
            return
        self.close()
        self._errors = tempfile.TemporaryFile("w+", errors="replace")
        self._process = subprocess.Popen(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                         stderr=self._errors, text=True)

    def _read_line(self, limit: float) -> str:
        """One line of the worker's output, "" at its end. Read piecewise: a line that never ends must time out too."""
        deadline, line, pipe = time.monotonic() + limit, b"", self._process.stdout.fileno()
        with selectors.DefaultSelector() as selector:
            selector.register(pipe, selectors.EVENT_READ)
            while not line.endswith(b"\n"):
                if selector.select(timeout=0.25):
                    piece = os.read(pipe, 1 << 16)
                    line += piece
                    if not piece:
                        return ""
                    if len(line) > LONGEST_ANSWER:
                        raise OSError("answer too long")
                if time.monotonic() > deadline:
                    raise TimeoutError
        return line.decode(errors="replace")

    def _obituary(self) -> str:
        if self._process is None:
            return "the renderer's process could not be started"
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout=5)
        code = self._process.poll()
        self._errors.seek(0)
        said = [line.strip() for line in self._errors.read()[-4000:].splitlines() if line.strip()]
        self.close()
        if code is None:
            how = "closed its output"
        elif code < 0:
            how = f"was killed by {signal.Signals(-code).name}"
        else:
            how = f"ended with exit code {code}"
        return f"the renderer's process {how}" + (f"; its last words: {said[-1][:300]}" if said else "")
