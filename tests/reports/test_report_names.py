"""Names made from untrusted texts."""

import re

import pytest

from raytruth.reports.text.words import slug


@pytest.mark.parametrize("text", ["../../etc/passwd", "a/b", "A", "a b", "", ".", "é", "x" * 500, "\x00b", "<>", "a.b"])
def test_names_are_plain_and_short(text):
    assert re.fullmatch(r"[a-z0-9][a-z0-9-]{0,99}", slug(text))


def test_plain_names_stay_and_others_stay_apart():
    assert slug("figure-05-sphere--paper") == "figure-05-sphere--paper"
    assert len({slug(t) for t in ("a b", "a-b", "a/b", "A-b", "a.b", "a_b")}) == 6
