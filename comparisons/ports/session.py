"""A port's process: started once, asked one thing after another, and ended with everything it started.

A port is a stranger's program. It runs in an empty folder of its own, which is removed; what it answers, keeps in memory,
writes and starts is bounded and looked at all the time, and what it started dies with it, also where that left its process
group. It is no sandbox: files elsewhere that its user may write, it may write too.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import resource
import shutil
import signal
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from raytruth.reference_tracer.errors import InputError

from ..execution.process import Worker
from . import protocol
from .picture import FinishedPicture, read
from .protocol import Declaration, Incoming, MalformedError, Question, Reply

MOST_MEMORY = 4 << 30  # bytes that all processes of a port may keep
MOST_PROCESSES = 128  # a browser has some twenty
MOST_WRITTEN = 256 << 20  # bytes in the port's folder
MOST_FILES = 10_000
MOST_SAID = 1 << 20  # bytes on the stdout of a port that only writes pictures
EVERY = 0.1  # seconds between two looks
PR_SET_CHILD_SUBREAPER = 36


@dataclass(frozen=True)
class Failure:
    """Why there is no answer: `verdict` is crashed, timeout or malformed."""

    verdict: str
    message: str


class _TooMuchError(Exception):
    """A port that goes beyond what it may use."""


class Port(Worker):
    """A port that speaks the protocol. A context manager: at its end the port and its folder are gone."""

    noun = "the port"

    def __init__(self, command: Sequence[str], memory: int = MOST_MEMORY):
        here = [str(Path(word).absolute()) if ("/" in word and Path(word).exists()) or Path(word).is_file() else word
                for word in command]  # it runs in a folder of its own
        super().__init__(here)
        self.memory, self.seq, self.declared = memory, 0, None
        self.folder = Path(tempfile.mkdtemp(prefix="raytruth-checked-"))
        self.environment = {**os.environ, "TMPDIR": str(self.folder), "HOME": str(self.folder)}
        self.started_with = {"cwd": self.folder, "preexec_fn": _bounded}
        self._others: set[int] = set()
        self._looked = 0.0

    def greet(self, limit: float) -> Declaration | Failure:
        """Starts the port and asks what it can."""
        found = self._asked(protocol.HELLO, limit, 0)
        if isinstance(found, Failure):
            return found
        try:
            self.declared = protocol.declaration(found[0])
            return self.declared
        except MalformedError as error:
            self._end()
            return Failure("malformed", str(error))

    def answer(self, question: Question, limit: float) -> Reply | Failure:
        """What the port answers within `limit` seconds; one that has ended is started and greeted anew."""
        if self._process is not None and not self._ended() and not self._is_silent():
            self._end()
            return Failure("malformed", "said more after its last answer, or closed its output")
        if self._process is None or self._ended():
            form = self.declared
            greeted = self.greet(limit)
            if isinstance(greeted, Failure):
                return greeted
            if form is not None and greeted != form:
                self._end()
                return Failure("malformed", "declares something else when it is started again")
        self.seq += 1
        found = self._asked(question.request(self.seq, self.declared.scenes), limit, question.most_bytes)
        if isinstance(found, Failure):
            return found
        try:
            return protocol.reply(question, self.seq, *found)
        except MalformedError as error:
            self._end()
            return Failure("malformed", str(error))

    def _asked(self, request: bytes, limit: float, most: int) -> tuple[Incoming, bytes] | Failure:
        """The answer to `request`, of at most so many bytes after its first line."""
        incoming = Incoming(most)
        said = self._exchanged(request, limit, incoming)
        if isinstance(said, Failure):
            return said
        if incoming.header is None or len(said) < incoming.end:
            short = "" if incoming.header is None else f", {incoming.end - len(said):,} bytes short of an answer"
            told = self._told()
            self._end()
            return Failure("crashed", told + short)
        return incoming, said

    def _waited(self, limit: float) -> Failure | None:
        """None if the process ends by itself with exit code 0. What it says is not listened to."""
        said = self._exchanged(b"", limit, lambda said: len(said) > MOST_SAID)
        if isinstance(said, Failure):
            return said
        told = self._told()
        return None if told == "the port ended with exit code 0" else Failure("crashed", told)

    def _exchanged(self, request: bytes, limit: float, whole: Callable[[bytes], bool]) -> bytes | Failure:
        try:
            if self._process is None:
                _subreaper()
                self._others = _children()
            self._start()
            return self._exchange(request, limit, lambda label, share: None, whole)
        except TimeoutError:
            failure = Failure("timeout", f"no answer within {limit:g} s")
        except MalformedError as error:
            failure = Failure("malformed", str(error))
        except _TooMuchError as error:
            failure = Failure("crashed", f"was ended: {error}")
        except OSError as error:
            if self._process is not None:  # it died before it had read the request
                return b""
            failure = Failure("crashed", f"cannot be started: {protocol.shown(self.command[0])} ({error.strerror})")
        self._end()
        return failure

    def _told(self) -> str:
        """How it ended, and its last words if it did not end well."""
        told = self._obituary(b"")
        fine, _, _ = told.partition("; its last words")
        return protocol.printable(fine if fine == "the port ended with exit code 0" else told, 400)

    # --- what it may use -------------------------------------------------------------------------------------------
    def _look_after(self) -> None:
        if time.monotonic() - self._looked < EVERY:
            return
        self._looked = time.monotonic()
        family = self._family()
        if len(family) > MOST_PROCESSES:
            raise _TooMuchError(f"it had {len(family)} processes; {MOST_PROCESSES} are allowed")
        if (kept := sum(family.values())) > self.memory:
            raise _TooMuchError(f"it kept {kept / 2**30:.1f} GiB of memory; {self.memory / 2**30:.1f} are allowed")
        files = size = 0
        for where, _, names in os.walk(self.folder):
            files += len(names)
            for name in names[:MOST_FILES]:
                with contextlib.suppress(OSError):
                    size += os.lstat(os.path.join(where, name)).st_blocks * 512
            if files > MOST_FILES or size > MOST_WRITTEN:
                raise _TooMuchError(f"it wrote {size >> 20} MiB in {files} files; {MOST_WRITTEN >> 20} MiB in {MOST_FILES} "
                                    "files are allowed")

    def _family(self) -> dict[int, int]:
        """The processes of the port, with the bytes that each keeps: its group, their descendants, and orphans of theirs,
        which fall to us (see `_subreaper`)."""
        me, root, found = os.getpid(), self._process.pid, _processes()
        ours = {pid for pid, (_, group, _) in found.items() if group == root}
        ours |= {pid for pid, (parent, _, _) in found.items() if parent == me and pid not in self._others}
        while more := {pid for pid, (parent, _, _) in found.items() if parent in ours and pid not in ours}:
            ours |= more
        return {pid: found[pid][2] for pid in ours}

    def _end(self) -> None:
        """Ends the process, all its descendants, and empties its folder."""
        if self._process is None:
            return
        for _ in range(100):  # what forks all the time may escape the first look
            family = self._family()
            for pid in family:
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.kill(pid, signal.SIGKILL)
            orphans = {pid for pid in family if pid != self._process.pid}
            for pid in orphans:
                with contextlib.suppress(ChildProcessError):
                    os.waitpid(pid, os.WNOHANG)
            if not orphans:
                break
            time.sleep(0.01)
        Worker.close(self)
        for entry in self.folder.iterdir():
            shutil.rmtree(entry, ignore_errors=True) if entry.is_dir() and not entry.is_symlink() else entry.unlink()

    def __exit__(self, *_):
        self._end()
        shutil.rmtree(self.folder, ignore_errors=True)


class Painter(Port):
    """A port without the protocol: it is run once a picture, as CMD SCENE PICTURE."""

    def __init__(self, command: Sequence[str], declared: Declaration, suffix: str, memory: int = MOST_MEMORY):
        super().__init__(command, memory)
        self.program, self.declared, self.suffix = self.command, declared, suffix

    def greet(self, limit: float) -> Declaration:
        return self.declared

    def answer(self, question: Question, limit: float) -> Reply | Failure:
        """The picture that it makes within `limit` seconds."""
        scene, picture = (self.folder / name for name in (f"scene.{_EXTENSION[self.declared.scenes]}", f"picture{self.suffix}"))
        scene.write_bytes(question.payload(self.declared.scenes))
        self.command = [*self.program, str(scene), str(picture)]
        failed = self._run_to_its_end(limit, lambda: read(picture))
        if isinstance(failed, Failure):
            return failed
        if failed.color.shape[:2] != question.shape:
            height, width = failed.color.shape[:2]
            return Failure("malformed", f"a picture of {width} x {height} pixels in place of {question.shape[1]} x "
                                        f"{question.shape[0]}")
        return Reply({"color": failed.color})

    def _run_to_its_end(self, limit: float, read_back: Callable[[], FinishedPicture]) -> FinishedPicture | Failure:
        """What it has left when it ends with exit code 0; the picture is read before its folder is emptied."""
        found = self._waited(limit)
        try:
            return found or read_back()
        except InputError as error:
            return Failure("malformed", protocol.printable(str(error).replace(str(self.folder), ""), 300))
        finally:
            self._end()


_EXTENSION = {"json": "json", "text": "txt"}


def _bounded() -> None:
    """In the child, before the port begins: no core dumps, no large files."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (MOST_WRITTEN, MOST_WRITTEN))


def _subreaper() -> None:
    """Orphans of our descendants become our children, so that none gets away."""
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def _children() -> set[int]:
    me = os.getpid()
    return {pid for pid, (parent, _, _) in _processes().items() if parent == me}


def _processes() -> dict[int, tuple[int, int, int]]:
    """Every process there is: its parent, its group, and the bytes of memory that it keeps."""
    page, found = os.sysconf("SC_PAGE_SIZE"), {}
    for name in os.listdir("/proc"):
        if name.isdigit():
            with contextlib.suppress(OSError, ValueError, IndexError):
                with open(f"/proc/{name}/stat", "rb") as file:
                    fields = file.read().rpartition(b")")[2].split()
                found[int(name)] = int(fields[1]), int(fields[2]), int(fields[21]) * page
    return found
