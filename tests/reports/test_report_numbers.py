"""How numbers are written."""

import math

import pytest

from raytruth.reports.text.numbers import MINUS, THIN, parts, powers


@pytest.mark.parametrize("value, text, exponent", [
    (0, "0", None), (-0.0, "0", None), (7, "7", None), (1234567, f"1{THIN}234{THIN}567", None),
    (0.5, "0.5", None), (0.450012, "0.450", None), (71.234, "71.2", None), (9.996, "10.0", None),
    (1234.56, f"1{THIN}235", None), (-2.01, f"{MINUS}2.01", None),
    (3.0001e-5, "3.00", f"{MINUS}5"), (5e-6, "5", f"{MINUS}6"), (1e-3, "", f"{MINUS}3"),
    (-1e-3, f"{MINUS}1", f"{MINUS}3"), (2.53e7, "2.53", "7"),
    (None, "–", None), (True, "yes", None), (False, "no", None),
    (math.nan, "not a number", None), (math.inf, "∞", None), (-math.inf, f"{MINUS}∞", None),
])
def test_numbers_are_written_with_three_digits_at_most(value, text, exponent):
    assert (parts(value).text, parts(value).exponent) == (text, exponent)


@pytest.mark.parametrize("value", [0.99981, 1.0002, 0.9999999, 1 - 1e-12, 1 + 3e-16, 0.996])
def test_an_almost_perfect_score_is_not_written_as_a_perfect_one(value):
    assert parts(value) != parts(1.0)


def test_near_one_the_digits_are_those_of_the_distance():
    assert parts(0.99981).text == "0.99981"
    assert (parts(1 - 2.5e-9).text, parts(1 - 2.5e-9).exponent) == (f"1 {MINUS} 2.50", f"{MINUS}9")


@pytest.mark.parametrize("value, text", [
    (0.5, "0.5"), (1e-9, "10⁻⁹"), (-2.51e12, f"{MINUS}2.51{THIN}×{THIN}10¹²"), (None, "–")])
def test_where_no_markup_is_possible_powers_are_raised_digits(value, text):
    assert str(parts(value)) == text


@pytest.mark.parametrize("text, shown", [
    ("99 % agree to 1.4e-06, no more", f"99 % agree to 1.4{THIN}×{THIN}10⁻⁶, no more"), ("down to p = 1e-14.", "down to p = 10⁻¹⁴."),
    ("5.8e+03 pixels", f"5.8{THIN}×{THIN}10³ pixels"), ("2^-16 of p^2", "2⁻¹⁶ of p²"), ("hash 25610cee016c, v1e5", "hash 25610cee016c, v1e5")])
def test_exponents_in_a_text_are_raised(text, shown):
    assert powers(text) == shown
