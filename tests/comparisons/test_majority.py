"""Who is the odd one out: votes by hand."""

import pytest

from comparisons.verdicts.majority import odd_ones

ALL = {"exact": "reference", "paper": "reference", "native": "mitsuba", "mesh": "mitsuba", "embree": "embree",
       "povray": "povray"}


def disagree(*who, among=ALL):
    """`who` disagree with all others, not among themselves."""
    return [(a, b) for a in who for b in among if b not in who]


def found(pairs, known="", among=ALL):
    return [odd.suspects for odd in odd_ones(among, pairs, known)]


def test_where_all_agree_nobody_is_odd():
    assert found([]) == []


@pytest.mark.parametrize("name", ALL)
def test_who_contradicts_everybody_is_odd_even_the_reference(name):
    odd, = odd_ones(ALL, disagree(name))
    assert odd.suspects == (name,) and set(odd.against) == ALL.keys() - {name}


def test_one_implementation_has_one_vote():
    # a fault in Mitsuba's shading: three pictures against three, but one implementation against two
    three = {"exact": "reference", "native": "mitsuba", "mesh": "mitsuba", "grid": "mitsuba", "embree": "embree"}
    assert sorted(found(disagree("native", "mesh", "grid", among=three), among=three)) == [("grid",), ("mesh",), ("native",)]


def test_two_wrong_ones_are_named_one_after_the_other():
    pairs = {frozenset(p) for p in disagree("povray") + disagree("mesh")}
    assert sorted(found(map(tuple, pairs))) == [("mesh",), ("povray",)]


def test_two_who_only_disagree_with_each_other_cannot_be_told_apart():
    odd, = odd_ones(ALL, [("mesh", "embree")])
    assert set(odd.suspects) == set(odd.against) == {"mesh", "embree"}


def test_of_equally_suspect_ones_it_is_the_one_known_to_err():
    odd, = odd_ones(ALL, [("exact", "paper")], "paper")
    assert odd.suspects == ("paper",) and odd.against == ("exact",)
    # but what is known about it excuses nobody else
    assert found(disagree("povray"), "paper") == [("povray",)]


def test_without_a_third_opinion_there_is_no_majority():
    two = {"exact": "reference", "povray": "povray"}
    assert found([("exact", "povray")], among=two) == [("exact", "povray")]
