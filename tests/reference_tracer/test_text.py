"""Lines and tables for terminals: nothing is lost, nothing is wider than the terminal, pipes get one line each."""

import pytest

from raytruth.reference_tracer import text

HEADS = ("", "proven hits", "proven misses", "undecided", "worst scene")
ROWS = [("primary", "34,873", "41,927", "0", "3 of 9: seed 12"), ("shadow", "1,885", "32,583", "1,000", "-")]


def narrow(monkeypatch, columns: int) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))


def test_a_pipe_gets_one_line(monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    prose = "word " * 200
    assert text.hanging("agrees ball", prose, gap=2) == f"agrees ball  {prose.strip()}"
    assert len(text.table(HEADS, ROWS).splitlines()) == 3


@pytest.mark.parametrize("columns, lines", [(80, ["agrees  one two three"]), (60, ["agrees  one two three"]),
                                            (20, ["agrees", "    one two three"])])
def test_prose_that_fits_stays(monkeypatch, columns, lines):
    narrow(monkeypatch, columns)
    assert text.hanging("agrees", "one two three", gap=2).splitlines() == lines


@pytest.mark.parametrize("columns", [20, 40, 80])
def test_prose_hangs_or_stands_below(monkeypatch, columns):
    narrow(monkeypatch, columns)
    prose = " ".join(f"word{k}" for k in range(60))
    lines = text.hanging("agrees ball", prose).splitlines()
    assert max(map(len, lines)) <= columns and " ".join(" ".join(lines).split()) == f"agrees ball {prose}"
    starts = {len(line) - len(line.lstrip()) for line in lines[1:]}
    assert starts == ({12} if columns == 80 else {4})  # beside only where 36 columns are left


def test_prose_below_nothing_begins_at_once(monkeypatch):
    narrow(monkeypatch, 30)
    assert text.hanging(" " * 18, "one two three four").splitlines() == ["    one two three four"]


@pytest.mark.parametrize("columns", [24, 40, 60, 200])
def test_a_table_keeps_its_cells_and_its_width(monkeypatch, columns):
    narrow(monkeypatch, columns)
    lines = text.table(HEADS, ROWS, left=(0, 4), indent=2).splitlines()
    assert max(map(len, lines)) <= max(columns, 2 + 7 + 2 + 15)  # a part is the first column and one more at least
    said = " ".join(lines)
    assert all(cell in said for row in ROWS for cell in row)
    assert all(word in said.split() for head in HEADS for word in head.split())


def test_numbers_stand_at_the_right(monkeypatch):
    narrow(monkeypatch, 80)
    assert text.table(("", "rays", "wrong"), [("primary", "9", "10"), ("shadow", "1,000", "0")]).splitlines() == [
        "          rays  wrong", "primary      9     10", "shadow   1,000      0"]


def test_two_lists_stand_side_by_side_where_they_fit(monkeypatch):
    narrow(monkeypatch, 20)
    assert text.side_by_side(["a", "bb"], ["c"]).splitlines() == ["a   |  c", "bb  |"]
    assert text.side_by_side(["a" * 10], ["b" * 10]).splitlines() == ["a" * 10, "", "b" * 10]
