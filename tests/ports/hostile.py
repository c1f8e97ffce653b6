"""Ports that do wrong on purpose, one by its name: python hostile.py NAME. All but the first few answer hello properly."""

import json
import os
import struct
import subprocess
import sys
import time

NAME = sys.argv[1]
DECLARES = {"protocol": 1, "name": "hostile", "levels": ["algorithm"], "precision": 64}


def say(head: dict, body: bytes = b"", times: int = 1) -> None:
    sys.stdout.buffer.write((json.dumps(head).encode() + b"\n" + body) * times)
    sys.stdout.buffer.flush()


def request() -> tuple[dict, list[str]]:
    line = sys.stdin.buffer.readline()
    if not line:
        sys.exit(0)
    head = json.loads(line)
    return head, sys.stdin.buffer.read(head["bytes"]).decode().splitlines()


def shape_of(lines: list[str]) -> list[int]:
    rays = sum(line.startswith("ray ") for line in lines)
    width, height = map(int, next(line for line in lines if line.startswith("camera ")).split()[-2:])
    return [rays] if rays else [height, width]


def answer(head: dict, lines: list[str], value: float = 0.5, times: int = 1, **changes) -> None:
    shape = shape_of(lines)
    count = 3 * shape[0] * (shape[1] if len(shape) > 1 else 1)
    body = struct.pack(f"<{count}d", *[value] * count)
    say({"seq": head["seq"], "state": "ok", "bytes": len(body),
         "arrays": [{"name": "color", "dtype": "float64", "shape": [*shape, 3]}], **changes}, body, times)


def forever() -> None:
    while True:
        time.sleep(1000)


def endless() -> None:
    while True:
        sys.stdout.buffer.write(b"x" * 65536)


def fork_on(detached: bool = False) -> None:
    for _ in range(300):
        subprocess.Popen(["sleep", "1009"], start_new_session=detached)
    forever()


def fill() -> None:
    for k in range(100):
        with open(os.path.join(os.environ["TMPDIR"], f"junk-{k}"), "wb") as file:
            for _ in range(64):
                file.write(b"\1" * (1 << 20))
    forever()


def swell() -> None:
    kept = []
    while True:
        kept.append(b"\1" * (64 << 20))


BEFORE = {  # hello
    "silent": forever, "endless": endless, "stderr only": lambda: [sys.stderr.write("noise\n" * 1000) for _ in range(10**9)],
    "exit 137": lambda: sys.exit(137), "garbage": lambda: (print("<html>hello</html>", flush=True), forever()),
    "killed": lambda: os.kill(os.getpid(), 9), "closes its output": lambda: (os.close(1), forever()),
    "nothing": lambda: sys.exit(0), "deep": lambda: (print("[" * 60000, flush=True), forever()),
}
AFTER = {  # a request
    "hang": lambda head, lines: forever(), "endless answer": lambda head, lines: endless(),
    "10 GB": lambda head, lines: answer(head, lines, bytes=10 << 30),
    "negative size": lambda head, lines: answer(head, lines, bytes=-1),
    "size in words": lambda head, lines: answer(head, lines, bytes="many"),
    "NaN": lambda head, lines: answer(head, lines, float("nan")),
    "infinite": lambda head, lines: answer(head, lines, float("inf")),
    "wrong shape": lambda head, lines: answer(head, lines, arrays=[{"name": "color", "dtype": "float64", "shape": [1, 1, 3]}]),
    "wrong dtype": lambda head, lines: answer(head, lines, arrays=[{"name": "color", "dtype": "complex", "shape": [2, 3]}]),
    "wrong seq": lambda head, lines: answer(head, lines, seq=head["seq"] + 1),
    "no colour": lambda head, lines: say({"seq": head["seq"], "state": "ok", "bytes": 0, "arrays": []}),
    "short": lambda head, lines: (say({"seq": head["seq"], "state": "ok", "bytes": 60, "arrays": []}, b"x"), sys.exit(0)),
    # in one piece: what comes after an answer has been read is found with the next request
    "twice": lambda head, lines: answer(head, lines, times=2),
    "late": lambda head, lines: (answer(head, lines), time.sleep(0.3), answer(head, lines)),
    "dies": lambda head, lines: sys.exit(137), "forks": lambda head, lines: fork_on(),
    "forks and detaches": lambda head, lines: fork_on(True), "fills the disk": lambda head, lines: fill(),
    "swells": lambda head, lines: swell(), "refuses": lambda head, lines: say(
        {"seq": head["seq"], "state": "unsupported", "message": "<script>alert(1)</script>\x1b[31m" + "long" * 1000}),
    "one grey": lambda head, lines: answer(head, lines),
}

if NAME in BEFORE:
    BEFORE[NAME]()
    sys.exit(0)
while True:
    head, lines = request()
    if head["op"] == "hello":
        say({**DECLARES, "name": "<script>alert(1)</script>\x1b[31m" if NAME == "one grey" else "hostile"})
    else:
        AFTER[NAME](head, lines)
