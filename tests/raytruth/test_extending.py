"""A surface, a renderer and a metric are each added as README says, by a file and its name in one list, and all the rest knows
them."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parents[2]
PACKAGES = ("reference_tracer", "converters", "comparisons", "reports", "raytruth")

CYLINDER = '''
from __future__ import annotations

from typing import ClassVar, Literal

from .surface import Length, Surface


class Cylinder(Surface):
    """A circular cylinder about the z axis. Unbounded."""

    type: Literal["cylinder"] = "cylinder"
    r: Length

    title: ClassVar[str] = "Cylinder"
    equation: ClassVar[str] = "(x − x₀)² + (y − y₀)² = r²"
    polynomial_degree: ClassVar[int] = 2

    @staticmethod
    def f(x, y, z, r):
        return x**2 + y**2 - r**2
'''

WITNESS = '''
from raytruth.reference_tracer.tracer.render import render as traced


def render(scene):
    return traced(scene, "interval")
'''

BIAS = '''
from .metrics import Planes


def bias(reference: Planes, test: Planes) -> dict[str, float]:
    return {"mean of green minus the reference's": float((test["color"] - reference["color"])[..., 1].mean())}
'''

SCENE = {"format": 1, "name": "cylinder", "camera": {"position": [0, 0, -4], "direction": [0, 0, 1], "up": [0, 1, 0], "width": 48, "height": 36},
         "lights": [{"position": [5, 5, -5]}],
         "objects": [{"surface": {"type": "cylinder", "center": [0, 0, 0], "r": 1},
                      "rotation": {"axis": [1, 0, 0], "degrees": 90}, "material": {"color": [1, 0.5, 0.2]}}]}


def listed(path: Path, before: str, after: str) -> None:
    text = path.read_text()
    assert text.count(before) == 1, f"{path.name} has no place {before!r}"
    path.write_text(text.replace(before, after))


@pytest.fixture
def house(tmp_path):
    """A copy of the packages to which one surface, one renderer and one metric were added."""
    for package in PACKAGES:
        shutil.copytree(HERE / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__", "html"))
    (tmp_path / "reference_tracer/surfaces/cylinder.py").write_text(CYLINDER)
    listed(tmp_path / "reference_tracer/surfaces/__init__.py", "from .ellipsoid", "from .cylinder import Cylinder\nfrom .ellipsoid")
    listed(tmp_path / "reference_tracer/surfaces/__init__.py", "Heart, Expression, Csg)", "Heart, Expression, Csg, Cylinder)")
    (tmp_path / "comparisons/renderers/witness.py").write_text(WITNESS)
    listed(tmp_path / "comparisons/renderers/__init__.py", "RENDERERS = {r.name: r for r in (",
           'RENDERERS = {r.name: r for r in (\n    Renderer("witness", "enclosures alone", "witness"),')
    (tmp_path / "comparisons/verdicts/bias.py").write_text(BIAS)
    listed(tmp_path / "comparisons/verdicts/measure.py", "\nfrom . import cond", "\nfrom .bias import bias\nfrom . import cond")
    listed(tmp_path / "comparisons/verdicts/measure.py", "METRICS = (", "METRICS = (bias, ")
    (tmp_path / "cylinder.json").write_text(json.dumps(SCENE))
    return tmp_path


def raytruth(house: Path, *arguments: str) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-m", "raytruth", *arguments], cwd=house, capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(house)})


def test_a_surface_a_renderer_and_a_metric_are_added_by_a_file_each(house):
    """The cylinder has no end within reach: 256 cells along it are too coarse, and the mesh alone is told to be off."""
    done = raytruth(house, "compare", "cylinder.json", "--renderers", "witness,mitsuba-mesh,paper", "--no-studies")
    assert done.returncode == 1, done.stdout + done.stderr
    results = json.loads((house / "results/results.json").read_text())
    verdicts = {c["id"].split("--")[1]: c["verdict"] for c in results["comparisons"]}
    assert verdicts == {"witness": "agrees", "mitsuba-mesh": "differs", "paper": "agrees"}, results["comparisons"]
    green = {c["id"].split("--")[1]: c["metrics"]["mean of green minus the reference's"] for c in results["comparisons"]}
    assert abs(green["witness"]) < 1e-15 < abs(green["mitsuba-mesh"]) < 1e-3, green
    assert raytruth(house, "report").returncode == 0
    assert any("mean of green minus the reference" in page.read_text() for page in (house / "reports/html").rglob("*.html"))
    matrix = json.loads((house / "results/matrix.json").read_text())
    assert [d["renderers"] for d in matrix["dissent"]] == [["mitsuba-mesh"]], matrix["dissent"]
    certified = raytruth(house, "certify", "cylinder.json", "--sample", "50")
    assert certified.returncode == 0, certified.stdout + certified.stderr
