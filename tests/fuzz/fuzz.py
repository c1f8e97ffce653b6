"""Hostile inputs against the command line: no traceback, no crash, no silence, no memory without end.

  python tests/fuzz/fuzz.py --inputs 5000             # what `make fuzz` does
  python tests/fuzz/fuzz.py --seed 0 --only 1234      # one input again, shown in full

Held against every input: it ends with exit code 0, 1 or 2; bad input with 2, nothing on stdout and exactly one sentence;
no traceback; never more than 2 GiB of memory; never 10 s of work without a word on what it will take and how far it is.
An input that tells both is ended then. Silence is counted in seconds of the processor, so that a busy machine does not
matter.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(Path(__file__).parent)]

import fuzz_inputs  # noqa: E402

MEMORY = 2 << 30  # bytes
SILENCE = 10.0  # seconds of work without a word on how far it is and how long it will take
STUCK = 60.0  # seconds without an answer and without work
LONGEST = 400.0  # seconds of work on one input, whatever it tells
LONGEST_SENTENCE = 700  # characters
ESTIMATE, PROGRESS = re.compile(r"^raytruth: .* will take ", re.MULTILINE), re.compile(r"\d% after \d", re.MULTILINE)
LEFT = re.compile(r"(about|[\d:]+ to) [\d:]+ left")
TICKS = os.sysconf("SC_CLK_TCK")


@dataclass
class Outcome:
    """How an input ended: its exit code, or why it was ended."""

    code: object  # int, "traceback", "crash", "silent", "memory", "stuck", "told"
    out: str
    err: str
    memory: int  # bytes at most, of the process
    work: float  # seconds of the processor

    @property
    def sentences(self) -> list[str]:
        """The lines on stderr that are no progress and no estimate."""
        return [line for line in self.err.splitlines() if line.strip() and not PROGRESS.search(line) and not ESTIMATE.match(line)]


def verdict(given: fuzz_inputs.Input, outcome: Outcome) -> str | None:
    """What is wrong with how `given` was answered, None if nothing is."""
    if outcome.memory > MEMORY:
        return f"took {outcome.memory / 2**30:.1f} GiB"
    if outcome.code == "told":
        return None if not given.must_fail else "works on bad input"
    if not isinstance(outcome.code, int):
        return f"{outcome.code}: {(outcome.err.strip().splitlines() or ['nothing said'])[-1][:300]}"
    if "Traceback" in outcome.err:
        return "prints a traceback"
    if outcome.code not in (0, 1, 2):
        return f"exit code {outcome.code}"
    if given.must_fail and outcome.code != 2:
        return f"bad input and exit code {outcome.code}"
    if outcome.code == 2:
        if len(outcome.sentences) != 1:
            return f"{len(outcome.sentences)} sentences instead of one"
        sentence = outcome.sentences[0]
        if not sentence.startswith("raytruth: ") or not sentence.isprintable() or not 20 < len(sentence) < LONGEST_SENTENCE:
            return f"not a clear sentence ({len(sentence)} characters)"
        if outcome.out:
            return "bad input and something on stdout"
    return None


class Worker:
    """A child that runs inputs one after the other, each in a folder of its own."""

    def __init__(self, folder: Path):
        self.folder, self.process = folder, None

    def run(self, given: fuzz_inputs.Input) -> Outcome:
        place = self.folder / "input"
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        arguments = given.lay(place)
        if self.process is None or self.process.poll() is not None:
            self._start()
        request = json.dumps({"folder": str(place), "arguments": arguments})
        self.process.stdin.write(request.encode() + b"\n")
        self.process.stdin.flush()
        self._forget_peak()
        started, heard = self._work(), time.monotonic()
        worked, code, peak, last = started, None, 0, False
        while code is None:
            if select.select([self.process.stdout], [], [], 0.05)[0]:
                line = self.process.stdout.readline()
                peak = max(peak, self._peak())
                answer = json.loads(line) if line else {"code": "crash"}
                code, last = answer["code"], answer.get("last", False)
                break
            peak, work = max(peak, self._peak()), self._work()
            if work > worked + 0.2:
                worked, heard = work, time.monotonic()
            said = _read(place / "stderr")
            if peak > MEMORY:
                code = "memory"
            elif ESTIMATE.search(said) and PROGRESS.search(said):
                code = "told"
            elif (work - started > SILENCE and not (PROGRESS.search(said) and (ESTIMATE.search(said) or LEFT.search(said)))) or work - started > LONGEST:
                code = "silent"
            elif time.monotonic() - heard > STUCK:
                code = "stuck"
        outcome = Outcome(code, _read(place / "stdout"), _read(place / "stderr"), peak, max(self._work(), worked) - started)
        if last or not isinstance(code, int):
            self.close()
        return outcome

    def close(self) -> None:
        if self.process:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
            for pipe in (self.process.stdin, self.process.stdout):
                with contextlib.suppress(OSError):
                    pipe.close()
            self.process = None

    def _start(self) -> None:
        self.close()
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "DRJIT_CACHE_DIR": str(self.folder)}
        self.process = subprocess.Popen([sys.executable, str(Path(__file__).with_name("fuzz_worker.py"))],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                        env=environment, start_new_session=True)

    def _forget_peak(self) -> None:
        with contextlib.suppress(OSError):
            Path(f"/proc/{self.process.pid}/clear_refs").write_text("5")

    def _peak(self) -> int:
        found = re.search(r"VmHWM:\s+(\d+)", _read(Path(f"/proc/{self.process.pid}/status")))
        return int(found[1]) << 10 if found else 0

    def _work(self) -> float:
        fields = _read(Path(f"/proc/{self.process.pid}/stat")).rpartition(")")[2].split()
        return sum(map(int, fields[11:15])) / TICKS if len(fields) > 15 else 0.0


def _read(path: Path) -> str:
    try:
        return path.read_text(errors="replace")
    except OSError:
        return ""


def run(numbers, seed: int, jobs: int = 1, each=lambda given, outcome, wrong: None) -> list[str]:
    """Runs inputs; what is wrong, a line each with the command that brings the input back."""
    waiting, lock, wrongs = iter(numbers), threading.Lock(), []

    def work(folder: Path):
        worker = Worker(folder)
        try:
            while True:
                with lock:
                    number = next(waiting, None)
                if number is None:
                    return
                given = fuzz_inputs.make(seed, number)
                outcome = worker.run(given)
                wrong = verdict(given, outcome)
                with lock:
                    if wrong:
                        wrongs.append(f"input {number} ({given.kind}): {wrong}; again: {command(seed, number)}")
                    each(given, outcome, wrong)
        finally:
            worker.close()

    with tempfile.TemporaryDirectory(prefix="raytruth-fuzz-") as name:
        threads = [threading.Thread(target=work, args=(Path(name) / str(k),)) for k in range(jobs)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    return wrongs


def command(seed: int, number: int) -> str:
    return f"python tests/fuzz/fuzz.py --seed {seed} --only {number}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--inputs", type=int, default=5000)
    parser.add_argument("--first", type=int, default=0, help="the number of the first input")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", type=int, metavar="K", help="input K alone, shown in full")
    options = parser.parse_args()
    from raytruth.comparisons.progress import Progress

    numbers = range(options.first, options.first + options.inputs) if options.only is None else [options.only]
    codes, kinds, peak, work = Counter(), Counter(), 0, 0.0
    with Progress(len(numbers)) as bar:
        def each(given, outcome, wrong):
            nonlocal peak, work
            codes[outcome.code] += 1
            kinds[given.kind] += 1
            peak, work = max(peak, outcome.memory), max(work, outcome.work)
            bar.step()
            if wrong:
                bar.log(f"input {given.number} ({given.kind}): {wrong}")
                bar.log(f"  again: {command(options.seed, given.number)}")
            if options.only is not None:
                shown = [a if len(a) < 200 else a[:200] + "..." for a in given.arguments]
                for name, content in given.files.items():
                    bar.log(f"{name}: {'a named pipe' if content is None else content[:2000]!r}")
                bar.log(f"raytruth {shown}\nended: {outcome.code}, {outcome.work:.1f} s, {outcome.memory >> 20} MiB\n"
                        f"stdout: {outcome.out[:2000]}\nstderr: {outcome.err[-4000:]}")

        wrongs = run(numbers, options.seed, options.jobs, each)
    told = ", ".join(f"{count} x {code}" for code, count in sorted(codes.items(), key=str))
    print(f"{len(numbers)} inputs ({', '.join(f'{n} {k}' for k, n in sorted(kinds.items()))}): {len(wrongs)} wrong; "
          f"ended with {told}; at most {peak / 2**30:.2f} GiB and {work:.0f} s of the processor on one")
    return 1 if wrongs else 0


if __name__ == "__main__":
    sys.exit(main())
