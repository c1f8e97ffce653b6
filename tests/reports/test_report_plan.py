"""The page of plans: every scene with its decisions, proof and savings; and no trust in what the document says."""

import json

import numpy as np
import pytest
from report_support import HOSTILE

from raytruth.comparisons.bench.document import Seconds, Spread
from raytruth.comparisons.execution import store
from raytruth.comparisons.planning import document as results
from raytruth.comparisons.planning.document import DecisionRecord, MeshTrial, Plan, Proof, Ratio, Saved, Trial
from raytruth.reference_tracer.errors import InputError
from raytruth.reference_tracer.tracer.image_files import to_8_bit
from raytruth.reports import build

WIDTH, HEIGHT = 8, 6


def make_plan(scene: str, holds: bool = True) -> Plan:
    spread = Spread(median=2.5, low=2.0, high=3.0)
    ratio = Ratio(wall=spread, cpu=spread, clock="cpu")
    decisions = [DecisionRecord(parameter="shadow", written="traced", planned="left out", changed=True,
                                evidence=HOSTILE, trials=[Trial(value=HOSTILE, change=0.25, holds=False)] * 2),
                 DecisionRecord(parameter="cutoff", written="0", planned="0", changed=False, withdrawn=True,
                                evidence="")]
    proof = Proof(pixels=48, held_back=24, largest=5e-4 if holds else 5e-2, excused=3, most_excused=7, holds=holds)
    saved = Saved(exact=ratio, paper=ratio, call=ratio, turns=5, others=1.5, rays_written=200, rays_planned=50,
                  seconds={"planned": Seconds(wall=1, cpu=1)})
    return Plan(scene=scene, title=f"Ball {HOSTILE}", figure="Figure 5", hash="0" * 64, width=WIDTH, height=HEIGHT,
                samples=1, tolerance=1e-3, margin=0.9, attempts=2, seconds=3.25, cpu_seconds=4.5, decisions=decisions,
                proof=proof, saved=saved,
                meshes=[MeshTrial(resolution=32, state="ok", over=9, largest=0.5),
                        MeshTrial(resolution=64, state="crashed", message=HOSTILE)],
                planned={"name": scene}, command=f"raytruth plan {HOSTILE}")


@pytest.fixture
def page(folder, tmp_path):
    color, change = np.full((HEIGHT, WIDTH, 3), 0.5), np.zeros((HEIGHT, WIDTH))
    change[2, 3] = np.nan
    for name, holds in (("ball", True), ("other", False)):
        plan = make_plan(name, holds).model_copy(update={"planes": f"{results.PLANES}/{name}.npz"})
        store.save(folder / plan.planes, color=to_8_bit(color), change=change)
        results.add(plan, folder)
    (folder / results.PLANES / "other.npz").write_bytes(b"nothing")  # costs its own pictures only
    build(folder, tmp_path / "html")
    return tmp_path / "html" / "plan.html"


def test_every_plan_is_shown_with_what_it_proves_and_saves(page):
    text = page.read_text()
    assert "is kept by 1 of 2 planned scenes" in text and "Does not keep its tolerance." in text
    for words in ("no shadow", "withdrawn", "2 values tried", "Resolution 32", "earlier attempt", ">25</span>"):
        assert words in text, words
    assert (page.parent / "images/plans/ball-change.png").exists()
    assert not (page.parent / "images/plans/other-change.png").exists() and "other.npz" in text
    assert "plan.html" in (page.parent / "index.html").read_text()


def test_texts_of_the_document_are_escaped(page):
    assert HOSTILE not in page.read_text()


def test_without_plans_there_is_no_page(folder, tmp_path):
    build(folder, tmp_path / "html")
    assert not (tmp_path / "html" / "plan.html").exists()


def test_a_document_that_lacks_something_is_refused_in_one_line(folder, tmp_path):
    plan = json.loads(results.document_of([make_plan("ball")]).model_dump_json())
    del plan["plans"][0]["saved"]["exact"]
    (folder / results.FILE).write_text(json.dumps(plan))
    with pytest.raises(InputError, match="plan.json.*raytruth plan"):
        build(folder, tmp_path / "html")
