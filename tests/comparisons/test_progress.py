"""How far the work is: on a terminal, and where none watches."""

import io
import os
import pty
import subprocess
import sys
import threading
import time

import pytest

from raytruth.comparisons import progress as module
from raytruth.comparisons.progress import Cases, Progress


def until(condition, seconds=30):
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "what was waited for did not come"
        time.sleep(0.01)


def progress_threads():
    return [thread for thread in threading.enumerate() if thread.name == "progress"]


def test_silent_work_still_tells_that_it_goes_on(monkeypatch):
    """The line comes while the work itself says nothing, names it, and tells the share."""
    said = io.StringIO()
    monkeypatch.setattr(sys, "stderr", said)
    monkeypatch.setattr(module, "EVERY", 0.01)
    with Progress(8, label="ball") as bar:
        bar.to(2)
        until(lambda: said.getvalue().count("ball: 25%") >= 2)
        bar.step(2, "compiling")
        until(lambda: "compiling: 50%" in said.getvalue())
    until(lambda: not progress_threads())


def test_quick_work_and_quiet_work_say_nothing(capsys, monkeypatch):
    Progress(3, label="quick").close()
    monkeypatch.setattr(module, "EVERY", 0.01)
    with Progress(3, quiet=True) as bar:
        bar.step()
        time.sleep(0.05)
        bar.log("case 1 agrees")
    assert capsys.readouterr() == ("", "")


def test_a_finished_case_is_a_line(capsys):
    with Progress(3) as bar:
        bar.log("sphere: agrees")
    assert capsys.readouterr().err == "sphere: agrees\n"


@pytest.mark.parametrize("share, elapsed, left", [(0.5, 60, "about 1:00 left"), (0.25, 3600, "about 3:00:00 left")])
def test_the_time_left_follows_from_the_share(monkeypatch, share, elapsed, left):
    bar = Progress(1, quiet=True)
    bar._start = time.monotonic() - elapsed - 0.5
    bar.to(share)
    assert left[:-7] in bar.line  # the seconds may move on between the two looks at the clock
    bar._moved = time.monotonic() - 60
    assert "left" not in bar.line, "work that has stood still for a minute tells nothing of what is left"


def test_where_the_pace_changes_the_time_left_is_a_range():
    bar = Progress(1, quiet=True)
    now = time.monotonic()
    bar.done, bar._start, bar._marks, bar._moved = 0.6, now - 100, [(now - 60, 0.5), (now, 0.6)], now
    # 0.6 in 100 s, and 0.1 in the last 60: the other 0.4 will take 67 s at the one pace, 240 at the other
    assert "1:06 to 4:00 left" in bar.line or "1:07 to 4:01 left" in bar.line or "1:06 to 4:01 left" in bar.line


def test_where_nothing_was_finished_of_late_only_a_least_time_is_told():
    bar = Progress(1, quiet=True)
    now = time.monotonic()
    bar.done, bar._start, bar._marks, bar._moved = 0.6, now - 200, [(now - 140, 0.6)], now  # nothing in the latter half
    assert bar.line.endswith("more than 2:13 left"), bar.line  # 0.4 at the pace of 0.6 in 200 s


def test_a_terminal_shows_a_bar_and_is_left_clean():
    """In a child with a terminal of its own: the bar appears, a logged line stays, the cursor comes back."""
    program = ("import time; from raytruth.comparisons.progress import Cases, Progress\n"
               "with Progress(4, label='ball [x]') as bar:\n"
               "    bar.to(2); time.sleep(.5); bar.log('case: agrees'); bar.close(); bar.to(3)\n")
    ours, theirs = pty.openpty()
    process = subprocess.Popen([sys.executable, "-c", program], stderr=theirs, env={**os.environ, "TERM": "xterm"})
    os.close(theirs)
    seen = b""
    while True:
        try:
            piece = os.read(ours, 4096)
        except OSError:  # the other end is closed
            break
        if not piece:
            break
        seen += piece
    os.close(ours)
    text = seen.decode()
    assert process.wait() == 0 and "50%" in text and "ball [x]" in text and "case: agrees" in text
    assert text.rindex("\x1b[?25h") > text.rindex("\x1b[?25l"), "the cursor must be shown again"


def test_nothing_is_told_of_work_of_which_none_is_expected_yet(monkeypatch):
    monkeypatch.setattr(module, "EVERY", 0.02)
    monkeypatch.setattr(sys, "stderr", said := io.StringIO())
    with Cases() as cases:
        assert not progress_threads()
        cases.expect(2)
        until(lambda: "0% after" in said.getvalue())
