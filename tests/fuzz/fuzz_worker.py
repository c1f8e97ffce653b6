"""The process that hostile inputs run in: a line of JSON in (arguments, folder), a line of JSON out (how it ended).

The command line is called in this process, which is started again when an input ends it. What it prints goes to files
that the parent watches.
"""

from __future__ import annotations

import json
import os
import sys
import traceback

MOST_RENDERS = 150  # after which the process ends: kernels pile up in it


def main() -> None:
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    from raytruth.cli import main as raytruth

    renders = 0
    for line in sys.stdin:
        request = json.loads(line)
        os.chdir(request["folder"])
        for number, name in ((1, "stdout"), (2, "stderr")):
            file = os.open(os.path.join(request["folder"], name), os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(file, number)
            os.close(file)
        try:
            code = raytruth([os.fsdecode(os.fsencode(a)) for a in request["arguments"]])
        except SystemExit as stop:
            code = stop.code
        except BaseException:  # what a user would see as a traceback
            traceback.print_exc()
            code = "traceback"
        sys.stdout.flush()
        sys.stderr.flush()
        renders += request["arguments"][0] == "render"
        answers.write(json.dumps({"code": code, "last": renders > MOST_RENDERS}) + "\n")
        if renders > MOST_RENDERS:
            return


if __name__ == "__main__":
    main()
