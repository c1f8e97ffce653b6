"""The wheel brings one name into an environment, and works beside other people's packages of the names that ours have."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parents[2]
OTHERS = ("converters", "reports", "comparisons", "reference_tracer")
PROGRAM = """
import raytruth, converters, reports
from raytruth.comparisons.execution.code import closure
from raytruth.reports.build import environment
assert reports.MINE and converters.MINE
assert raytruth.__file__.startswith({site!r}) and raytruth.reports.__file__.startswith({site!r}), raytruth.__file__
picture = raytruth.render(raytruth.find_scene("figure-05-sphere").resized(8, 6))
assert (picture.index == 0).any()
assert environment().get_template("index.html.j2") and "raytruth.reference_tracer.tracer.world" in closure(
    "raytruth.comparisons.renderers.reference")[0]
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A folder with the wheel's contents, and others' packages."""
    folder = tmp_path_factory.mktemp("wheel")
    sources = subprocess.run(["git", "ls-files"], cwd=HERE, capture_output=True, text=True)
    if sources.returncode:
        pytest.skip("the wheel is built from what git tracks; this is no checkout")
    for name in sources.stdout.split():
        (folder / "source" / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / "source" / name).write_bytes((HERE / name).read_bytes())
    subprocess.run([sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "-w", folder,
                    folder / "source"], check=True, capture_output=True)
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as wheel:
        wheel.extractall(folder / "site")
    for name in OTHERS:
        (folder / "site" / name).mkdir()
        (folder / "site" / name / "__init__.py").write_text("MINE = True\n")
    return folder / "site"


def test_it_brings_one_name(site):
    assert {p.name for p in site.iterdir() if p.suffix != ".dist-info"} == {"raytruth", *OTHERS}


def test_it_works_from_any_folder_beside_others_of_our_packages_names(site, tmp_path):
    done = subprocess.run([sys.executable, "-c", PROGRAM.format(site=str(site))], cwd=tmp_path, capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(site)})
    assert done.returncode == 0, done.stderr
    assert (site / "raytruth/py.typed").exists() and (site / "raytruth/reports/published.json").exists()


def test_its_command_line_works(site, tmp_path):
    done = subprocess.run([sys.executable, "-m", "raytruth", "render", "figure-05-sphere", "--size", "8x6", "-o", "a.png"],
                          cwd=tmp_path, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(site)})
    assert done.returncode == 0 and (tmp_path / "a.png").exists(), done.stderr
