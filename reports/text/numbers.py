"""How numbers are written: three digits at most, powers of ten as such, the same on every page and in every chart."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

MINUS, THIN = "\N{MINUS SIGN}", "\N{NARROW NO-BREAK SPACE}"
PLAIN_FROM, PLAIN_BELOW = 0.01, 1e5  # between these a number is written without a power of ten
NEAR_ONE, MOST_DECIMALS = 0.005, 7
RAISED = str.maketrans(MINUS + "0123456789n", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹ⁿ")


@dataclass(frozen=True)
class Number:
    """`text`, times ten to the `exponent` if there is one; an empty text is a bare power of ten."""

    text: str
    exponent: str | None = None

    def __str__(self) -> str:
        """Where no markup is possible: in charts, and in texts that a pointer calls up."""
        if self.exponent is None:
            return self.text
        return (f"{self.text}{THIN}×{THIN}" if self.text else "") + "10" + self.exponent.translate(RAISED)


def parts(value) -> Number:
    """How `value` (a number, a bool or None) is written."""
    if value is None:
        return Number("\N{EN DASH}")
    if isinstance(value, bool):
        return Number("yes" if value else "no")
    if isinstance(value, int) or (math.isfinite(value) and value == int(value) and abs(value) < PLAIN_BELOW):
        return Number(_signed(f"{int(value):,}".replace(",", THIN)))
    if math.isnan(value):
        return Number("not a number")
    if math.isinf(value):
        return Number("∞" if value > 0 else MINUS + "∞")
    if abs(value - 1) < NEAR_ONE:
        return _near_one(value)
    if is_plain(value):
        return Number(_signed(_three_digits(value)))
    return power(value)


def is_plain(value: float) -> bool:
    """Whether a number is written without a power of ten."""
    return value == 0 or PLAIN_FROM <= abs(value) < PLAIN_BELOW


def power(value: float) -> Number:
    """A number other than 0 with its power of ten."""
    mantissa, exponent = f"{value:.2e}".split("e")
    mantissa = _without_idle_zeros(mantissa, f"{mantissa}e{exponent}", value)
    return Number("" if mantissa == "1" else _signed(mantissa), _signed(str(int(exponent))))


def powers(text: str) -> str:
    """Plain text with its exponents raised: 2^-16, and 1.4e-06, which is how Python writes numbers."""
    text = re.sub(r"(?<![\w.])(\d+(?:\.\d+)?)e([+-]?)0*(\d+)\b", lambda found: str(Number(
        "" if found[1] == "1" else found[1], (MINUS if found[2] == "-" else "") + found[3])), text)
    return re.sub(r"\^(-?[0-9n]+)", lambda found: found[1].replace("-", MINUS).translate(RAISED), text)


def _near_one(value: float) -> Number:
    """A score that is almost perfect must not be rounded to a perfect one."""
    distance = power(abs(1 - value))
    decimals = 1 - int(distance.exponent.replace(MINUS, "-"))
    if decimals <= MOST_DECIMALS:
        return Number(f"{value:.{decimals}f}".rstrip("0"))
    return Number(f"1 {MINUS if value < 1 else '+'} {distance.text or 1}", distance.exponent)


def _three_digits(value: float) -> str:
    decimals = max(0, 2 - int(f"{value:.2e}".split("e")[1]))
    return _without_idle_zeros(f"{value:,.{decimals}f}".replace(",", THIN), f"{value:.{decimals}f}", value)


def _without_idle_zeros(text: str, rounded: str, value: float) -> str:
    """Zeros at the end stand for measured digits; a number that needed no rounding, a limit say, goes without."""
    return text.rstrip("0").rstrip(".") if "." in text and float(rounded) == value else text


def _signed(text: str) -> str:
    return text.replace("-", MINUS)
