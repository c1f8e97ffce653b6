"""The table of decisions."""

import pytest

from raytruth.reports.pages.decisions import Decision, parse, pieces, prose, read_decisions

TABLE = "text\n\n| id | section | question | decision |\n|---|---|---|---|\n| A1 | 4.1 | why | do `x` then y |\n\nend\n"


def test_rows_are_read():
    assert parse(TABLE) == [Decision("A1", "4.1", "why", "do `x` then y")]


def test_the_shipped_decisions_have_unique_ids_and_no_empty_cell():
    decisions = read_decisions()
    assert {"E1", "C1", "M3", "L3", "S1"} <= {d.id for d in decisions}
    assert len({d.id for d in decisions}) == len(decisions)
    assert all(d.section and d.question and d.decision for d in decisions)


def test_a_file_without_the_table_is_an_error():
    with pytest.raises(ValueError, match="table"):
        parse(TABLE.replace("section", "chapter"))


def test_code_is_kept_apart_from_prose():
    assert pieces("do `x` then `y`") == [(False, "do "), (True, "x"), (False, " then "), (True, "y")]


def test_prose_is_escaped():
    assert prose("<b> `a<b`") == "&lt;b&gt; <code>a&lt;b</code>"
