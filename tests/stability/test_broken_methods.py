"""The suite finds methods that are broken, and says which: a suite that finds nothing proves nothing."""

import dataclasses

import pytest
from broken_methods import FREE_NEWTON, SKIPS_ROOTS, WRONG_SIDE

from raytruth.comparisons.stability import cases as families
from raytruth.comparisons.stability.family import Law
from raytruth.comparisons.stability.measure import examine
from raytruth.comparisons.stability.methods import METHODS

EXACT = next(m for m in METHODS if m.name == "exact")
PAPER = METHODS[0]


def _findings(names, methods, rays=400):
    """The records by family, and what is wrong and not flagged."""
    examined = [examine(family, methods, rays) for family in families.find(names)]
    return ({e.record.id: e.record for e in examined},
            [f for e in examined for f in e.findings if f.what == "wrong and not flagged"])


@pytest.mark.parametrize("method, names, kind", [
    (SKIPS_ROOTS, ["camera-distance", "thin-shell"], "missed"),
    (WRONG_SIDE, ["secondary-rays", "slab-stack"], None),
    (FREE_NEWTON, ["steep", "multiple-root"], "diverged")])
def test_a_broken_method_is_found_and_named(method, names, kind):
    """Beside `exact`, which stays without a finding on the same families."""
    _, findings = _findings(names, [EXACT, method])
    assert {f.family for f in findings} == set(names)
    for finding in findings:
        assert finding.method == method.name and method.name in finding.sentence
        assert kind is None or finding.kinds[0] == kind
        assert finding.example["kind"] in finding.kinds


def test_one_root_in_fifty_is_enough_to_be_found():
    """2 % of 400 rays are 8; none of them escapes, and nothing else is blamed on the method."""
    records, findings = _findings(["camera-distance"], [EXACT, SKIPS_ROOTS])
    every = records["camera-distance"].series
    series = next(s for s in every if (s.method, s.precision) == ("skips roots", 64))
    assert all(set(p.counts) <= {"correct", "missed"} for p in series.points)
    assert 0.002 < sum(findings[0].rates) / len(findings[0].rates) < 0.06


def test_the_wrong_side_does_no_harm_to_camera_rays():
    """It is the secondary rays that betray it: the same method is right on every ray that starts in free space."""
    _, findings = _findings(["camera-distance", "small-ball"], [WRONG_SIDE])
    assert findings == []


def test_answers_flagged_undecided_are_no_finding():
    """A proof may decline: on f = q^2 it declines on every ray, which is no wrong answer."""
    records, findings = _findings(["even-root"], METHODS, rays=100)
    proof = next(s for s in records["even-root"].series if s.method == "proof")
    assert findings == [] and all(p.rate("undecided") == 1 for p in proof.points)


@pytest.mark.parametrize("name, wrong_rate", [
    ("grazing", lambda p: max(0.0, 1 - (2 * p) ** 0.5 / 0.05)),  # half the chord
    ("steep", lambda p: max(0.0, 1 - 1.5 / p)),
    ("small-ball", lambda r: 1.0 if r < 0.025 else 0.0)])
def test_a_wrong_law_is_broken(name, wrong_rate):
    family, = families.find([name])
    told = dataclasses.replace(family, laws=(Law("paper", "a wrong law", wrong_rate),))
    found = examine(told, [PAPER], rays=400)
    record, findings = found.record, found.findings
    assert not record.laws[0].holds
    assert [f.method for f in findings] == ["paper"] and findings[0].what == "law broken"
    assert set(findings[0].values) <= set(record.values)


def test_a_method_with_another_step_breaks_the_laws_of_the_stated_one():
    """The literal method at h = 0.1 in place of 0.05: chords are missed twice as often."""
    coarse = dataclasses.replace(PAPER, build=lambda s: PAPER.build(dataclasses.replace(s, step=s.step * 2)))
    for name in ("grazing", "small-ball", "thin-shell", "steep"):
        family, = families.find([name])
        assert all(law.holds for law in examine(family, [PAPER], 400).record.laws)
        assert not all(law.holds for law in examine(family, [coarse], 400).record.laws)


def test_methods_that_claim_exactness_are_not_wrong_unflagged_on_hard_roots():
    """A root that is refined too little, because a small step was taken for a small error, shows here first."""
    claiming = [m for m in METHODS if m.name in ("exact", "proof")]
    _, findings = _findings(["root-set", "multiple-root", "translated", "scaled-f", "grazing"], claiming, rays=100)
    assert not findings, [f.sentence for f in findings]
