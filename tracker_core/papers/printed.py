"""Numbers as a document prints them."""

from __future__ import annotations

import re
from decimal import Decimal

from tracker_core.checks import InputError

EMPTY = "–"
"""Stands in a cell in which the document prints nothing."""

_POWER = re.compile(r"(?:10(?=-)|(?P<mantissa>-?[\d.]+)(?: × 10|e|(?=-)))(?P<exponent>[-+]?\d+)")
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻−", "0123456789--")


def number(printed: str) -> Decimal:
    """The number that a document prints, exactly.

    Thousands may be grouped by commas; powers of ten may be written 4.2e-003, 4.2 × 10⁻³, 4.2-03 or 10⁻³.

    Raises:
        InputError: for what is no number.
    """
    text = printed.translate(_SUPERSCRIPTS).replace(",", "")
    power = _POWER.fullmatch(text)
    try:
        return Decimal(f"{power['mantissa'] or 1}e{power['exponent']}" if power else text)
    except ArithmeticError:
        raise InputError("printed", "must be a number", printed) from None


def half_unit(printed: str) -> Decimal:
    """Half a unit of the last digit that a document prints."""
    return Decimal(5).scaleb(int(number(printed).as_tuple().exponent) - 1)
