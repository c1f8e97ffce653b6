"""Wrong on purpose: which renderer alone notices which fault of the reference tracer, and what it takes it for."""

from __future__ import annotations

from pathlib import Path

from reference_tracer.scene import library

from .. import document
from ..execution.pool import Pool, Progress
from ..renderers import RENDERERS
from .made import Task, make_all
from .records import FILE, Judgement, Made, Table, WrongOnPurpose
from .wrong import FAULTS, Fault

JUDGES = ("mitsuba-native", "povray")  # renderers that share no tracing with the reference
WIDTH, HEIGHT = 240, 180
COMMAND = "raytruth attribute --wrong-on-purpose"


def wrong_on_purpose(folder: Path, *, jobs: int = 2, progress: Progress | None = None) -> Table:
    """Puts every fault, and none, before every judge, and writes attribution.json into `folder`."""
    judges = [name for name in JUDGES if name in RENDERERS]
    tasks = {(fault.id, fault.effect): fault for fault in FAULTS.values()}
    tasks.update({("", effect): None for effect in library.effects()})
    asked = {(id, effect, judge): Task(library.scene(effect).resized(WIDTH, HEIGHT), judge, fault=id)
             for id, effect in tasks for judge in judges}
    with Pool(jobs, progress) as pool:
        made = make_all(list(asked.values()), folder, pool)
    rows = [_row(fault, effect, [_judgement(judge, made[asked[id, effect, judge]]) for judge in judges])
            for (id, effect), fault in tasks.items()]
    table = Table(width=WIDTH, height=HEIGHT, rows=rows, command=COMMAND)
    document.write(table, folder / FILE)
    return table


def read(folder: Path) -> Table:
    """The table in `folder`. Raises InputError in one line."""
    return document.read(folder / FILE, Table, COMMAND)


def _row(fault: Fault | None, effect: str, judgements: list[Judgement]) -> WrongOnPurpose:
    if fault is None:
        return WrongOnPurpose(id="right", title="the tracer as it is", effect=effect, right="", wrong="", expected=None,
                              because="nothing is wrong: nothing may be found", judgements=judgements)
    return WrongOnPurpose(id=fault.id, title=fault.title, effect=effect, right=fault.right.strip(),
                          wrong=fault.wrong.strip(), expected=fault.stage, because=fault.because, judgements=judgements)


def _judgement(name: str, made: Made) -> Judgement:
    about = {"renderer": name, "title": RENDERERS[name].title, "state": made.state, "message": made.message}
    if made.judged is None:
        return Judgement(**about)
    return Judgement(**about, found=made.judged.found, reason=made.judged.reason, attribution=made.judged.attribution)
