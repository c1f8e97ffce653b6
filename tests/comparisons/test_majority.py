"""Who is the odd one out: votes by hand."""

import pytest

from raytruth.comparisons.results import Run
from raytruth.comparisons.verdicts.majority import odd_ones, stages_of

ALL = {"exact": frozenset({"reference", "exact hits"}), "paper": frozenset({"reference", "literal hits"}),
       "native": frozenset({"foreign", "mitsuba", "shapes"}), "mesh": frozenset({"foreign", "mitsuba", "meshes"}),
       "embree": frozenset({"foreign", "embree", "meshes"}), "povray": frozenset({"povray", "povray hits"})}


def disagree(*who, among=ALL):
    """`who` disagree with all others, not among themselves."""
    return [(a, b) for a in who for b in among if b not in who]


def without(*names):
    return {name: stages for name, stages in ALL.items() if name not in names}


def test_where_all_agree_nobody_is_odd():
    assert odd_ones(ALL, []) is None


@pytest.mark.parametrize("name", ["exact", "paper", "native", "embree", "povray"])
def test_who_contradicts_everybody_is_odd_even_the_reference(name):
    odd = odd_ones(ALL, disagree(name))
    assert odd.suspects == (name,) and set(odd.against) == ALL.keys() - {name} and not odd.split


def test_two_tracers_of_one_mesh_are_one_voice():
    # gyroid-shell: two pictures against two, but one geometry against two
    four = without("paper", "native")
    odd = odd_ones(four, disagree("mesh", "embree", among=four))
    assert odd.suspects == ("mesh", "embree") and odd.against == ("exact", "povray") and not odd.split


def test_a_shading_that_is_wrong_takes_all_that_share_it():
    odd = odd_ones(ALL, disagree("native", "mesh", "embree"))
    assert odd.suspects == ("native", "mesh", "embree") and odd.stages == ("foreign",)
    odd = odd_ones(ALL, disagree("exact", "paper"))
    assert odd.suspects == ("exact", "paper") and odd.stages == ("reference",)


def test_a_mesh_that_is_wrong_with_one_tracer_alone_cannot_be_told_apart():
    """The mesh in Mitsuba differs from all, Embree on it and native shapes in Mitsuba from nobody else: none of its stages."""
    assert odd_ones(ALL, disagree("mesh")).split


def test_two_wrong_ones_are_both_named():
    odd = odd_ones(ALL, {*map(frozenset, disagree("povray")), *map(frozenset, disagree("native"))})
    assert odd.suspects == ("native", "povray") and not odd.split


def test_two_who_only_disagree_with_each_other_cannot_be_told_apart():
    odd = odd_ones(without("paper"), [("exact", "povray")])
    assert odd.split and odd.suspects == ("exact", "povray")


@pytest.mark.parametrize("names", [("exact", "povray"), ("exact", "mesh", "embree")])
def test_without_a_third_voice_there_is_no_majority(names):
    few = {name: ALL[name] for name in names}
    odd = odd_ones(few, disagree("exact", among=few))
    assert odd.split and set(odd.suspects) == set(names)


def test_nobody_is_a_favourite_or_a_scapegoat_by_name():
    """Other names for the same stages give the same answer under those names."""
    other = dict(zip(ALL, ("paper", "exact", "povray", "embree", "mesh", "native")))
    for who in ALL:
        odd = odd_ones(ALL, disagree(who))
        renamed = odd_ones({other[n]: s for n, s in ALL.items()}, [(other[a], other[b]) for a, b in disagree(who)])
        assert renamed.suspects == tuple(other[n] for n in odd.suspects) and renamed.split == odd.split


def run(renderer, **facts):
    return Run(key=renderer, scene="ball", renderer=renderer, title="", state="ok", command="",
               settings={"resolution": 256}, facts=facts)


def test_the_stages_of_runs():
    mesh, embree = stages_of(run("mitsuba-mesh", triangles=9), "mitsuba"), stages_of(run("embree", triangles=9), "embree")
    assert len(mesh & embree) == 2  # triangles and shading
    native = stages_of(run("mitsuba-native", native_shapes=1, triangles=0), "mitsuba")
    mixed = stages_of(run("mitsuba-native", native_shapes=1, triangles=9), "mitsuba")
    assert len(native & mesh) == 2 and native | mesh == mixed  # tracing and shading
    exact, paper, povray = (stages_of(run(n), m) for n, m in (("exact", "reference"), ("paper", "reference"), ("povray", "povray")))
    assert len(exact & paper) == 1 and not povray & (exact | mesh) and not exact & mesh
