"""How numbers are written: three digits at most, powers of ten as such, the same on every page."""

from __future__ import annotations

import math
from dataclasses import dataclass

MINUS, THIN = "\N{MINUS SIGN}", "\N{NARROW NO-BREAK SPACE}"
PLAIN_FROM, PLAIN_BELOW = 0.01, 1e5  # between these a number is written without a power of ten


@dataclass(frozen=True)
class Number:
    """`text`, times ten to the `exponent` if there is one; an empty text is a bare power of ten."""

    text: str
    exponent: str | None = None


def parts(value) -> Number:
    """How `value` (a number, a bool, a text or None) is written."""
    if value is None:
        return Number("\N{EN DASH}")
    if isinstance(value, bool):
        return Number("yes" if value else "no")
    if isinstance(value, str):
        return Number(value)
    if isinstance(value, int) or (math.isfinite(value) and value == int(value) and abs(value) < PLAIN_BELOW):
        return Number(_signed(f"{int(value):,}".replace(",", THIN)))
    if math.isnan(value):
        return Number("not a number")
    if math.isinf(value):
        return Number("∞" if value > 0 else MINUS + "∞")
    if PLAIN_FROM <= abs(value) < PLAIN_BELOW:
        return Number(_signed(_three_digits(value)))
    mantissa, exponent = f"{value:.1e}".split("e")
    mantissa = mantissa.removesuffix(".0")
    return Number("" if mantissa == "1" else _signed(mantissa), _signed(str(int(exponent))))


def _three_digits(value: float) -> str:
    decimals = max(0, 2 - math.floor(math.log10(abs(value))))
    text = f"{value:,.{decimals}f}".replace(",", THIN)
    return text.rstrip("0").rstrip(".") if "." in text else text


def _signed(text: str) -> str:
    return text.replace("-", MINUS)
