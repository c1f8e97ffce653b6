"""Cases that a cluster's workers make in tests; the process that asks is the Dask worker."""

import os
import signal
import time
from pathlib import Path


def well(arguments):
    return {"state": "ok", "facts": {"number": arguments["number"] ** 2}}


def counted(arguments):
    """Leaves a mark a run, so that a test can count them."""
    with Path(arguments["marks"]).open("a") as file:
        file.write(f"{arguments['number']}\n")
    return well(arguments)


def hangs(arguments):
    time.sleep(600)


def dies(arguments):
    os.kill(os.getpid(), signal.SIGKILL)


def ends_its_worker(arguments):
    """The first `times` that it is made."""
    marks = Path(arguments["marks"])
    made = len(marks.read_text()) if marks.exists() else 0
    if made < arguments["times"]:
        marks.write_text("x" * (made + 1))
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(60)
    return well(arguments)


def waits(arguments):
    """Until somebody opens the gate; says that it has begun."""
    Path(arguments["begun"]).touch()
    while not Path(arguments["gate"]).exists():
        time.sleep(0.05)
    return well(arguments)
