"""A results document with every kind of case, and the faults put into its pictures."""

import re
from pathlib import Path

from raytruth.comparisons import results as documents
from raytruth.comparisons.results import Comparison, Gate, Machine, Results, Run, SceneRecord, Series, Timing
from raytruth.reference_tracer.tracer.image_files import save_npz

WIDTH, HEIGHT = 32, 24
HOSTILE = "<script>alert('x')</script>\"&"
ERROR_AT = {(10, 16): 1e-3, (11, 16): 3e-6, (12, 16): 1e-12, (13, 16): 7.0}  # (row, column): error put into a channel
NAN_AT, UNDECIDED_AT, MISMATCH_AT = (12, 12), (12, 20), (14, 16)


def make_results(scene) -> Results:
    record = SceneRecord(name=scene.name, title=f"Sphere {HOSTILE}", figure="Figure 5", description=HOSTILE,
                         estimates="all", hash=scene.hash, width=WIDTH, height=HEIGHT, samples=1,
                         objects=[f"ball {HOSTILE}"], surfaces=["sphere"])
    empty = record.model_copy(update={"name": f"../../odd {HOSTILE}", "title": ""})
    runs = [make_run("good"), make_run("bad"), make_run("paper"), make_run("gone"),
            make_run("crash", state="crashed", message=f"signal 11 {HOSTILE}"),
            make_run("refused", state="refused", message="no hearts here")]
    comparisons = [make_comparison("same", "good", "agrees"), make_comparison("faulty", "bad", "differs", holds=False),
                   make_comparison("steps", "paper", "expected"), make_comparison("lost", "gone", "agrees"),
                   make_comparison("none", "crash", "not compared")]
    series = Series(id="ladder", title=f"Error {HOSTILE}", x_label="cells", y_label="error", expected="slope -2",
                    lines={"sphere": [(32.0, 1e-2), (64.0, 2.5e-3), (128.0, 0.0)], "none": []}, holds=True,
                    slope={"sphere": -2.0}, command="raytruth compare")
    machine = Machine(processor="two cores", cores=2, memory_gib=8, system="Linux", python="3.11",
                      packages={"numpy": "2"}, source="0" * 64)
    return Results(created="2025-01-02T03:04:05+00:00", seconds=1.5, machine=machine, scenes=[record, empty], runs=runs,
                   comparisons=comparisons, series=[series])


def make_folder(results: Path, pictures: dict) -> Path:
    """A results folder with those pictures of runs, by the name of the run."""
    (results / documents.RUNS).mkdir(parents=True)
    for name, picture in pictures.items():
        save_npz(picture, results / documents.RUNS / f"{name}.npz")
    documents.write(make_results(pictures["good"].scene), results)
    return results


def make_run(name: str, state: str = "ok", message: str = "") -> Run:
    planes = f"{documents.RUNS}/{name}.npz" if state == "ok" else None
    return Run(key=name, scene="figure-05-sphere", renderer=name, title=f"Renderer {name}", state=state,
               message=message, planes=planes, timing=Timing(first=1.25),
               facts={"rays": 768, "note": HOSTILE}, command=f"raytruth render {HOSTILE}")


def make_comparison(id: str, test: str, verdict: str, holds: bool = True) -> Comparison:
    gate = Gate(name="color p99", value=1e-4 if holds else 5e-2, limit=1e-3, holds=holds, means=HOSTILE)
    return Comparison(id=id, scene="figure-05-sphere", reference="good", test=test, against="model", verdict=verdict,
                      reason=f"because {HOSTILE}", gates=[gate], metrics={"color max": 7.0, "SSIM": None},
                      worst=[{"row": 13, "col": 16, "error": 7.0}, {"row": 900, "col": 0, "error": 1.0}],
                      command="raytruth compare")


def marks_of(svg: str, line: str) -> list[tuple[float, float]]:
    """Where the marks of a chart's line stand; y runs downwards."""
    group = svg[svg.index(f'id="{line}"'):]
    marks = re.search(r"<g[^>]*>\s*((?:<use[^>]*/>\s*)+)", group)[1]
    return [(float(x), float(y)) for x, y in re.findall(r'x="([-\d.]+)" y="([-\d.]+)"', marks)]
