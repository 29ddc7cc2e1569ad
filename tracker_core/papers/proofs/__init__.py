"""Proofs of the errata: each computed from the core and the printed cells, by the name that an erratum gives."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from tracker_core.checks import check_choice
from tracker_core.papers.proof import Proof
from tracker_core.papers.proofs import alwagih, alwagih_significance, garg, jeong, jeong_gains, yu_wu, yu_wu_tables

PROOFS: dict[str, Callable[[], Proof]] = {
    "jeong-zero-gamma": jeong_gains.zero_gamma,
    "jeong-precedence": jeong_gains.precedence,
    "jeong-xi": jeong_gains.discounting,
    "jeong-doubled-gain": jeong_gains.doubled_gain,
    "jeong-conventions": jeong_gains.conventions,
    "jeong-differences": jeong.differences,
    "jeong-gray-murray": jeong_gains.gray_murray,
    "jeong-tracking-total": jeong.tracking_total,
    "jeong-worst": jeong.worst,
    "jeong-one-search": jeong.one_search,
    "njonjo-conventions": jeong_gains.fragment,
    "yu-jury": yu_wu.jury,
    "yu-degenerate": yu_wu.degenerate,
    "yu-oracle": yu_wu.oracle,
    "yu-misprints": yu_wu.misprints,
    "yu-digits": yu_wu_tables.swapped_digits,
    "yu-undefined": yu_wu_tables.undefined,
    "yu-swapped": yu_wu_tables.swapped_columns,
    "yu-manoeuvre": yu_wu.manoeuvre,
    "yu-monotone": yu_wu_tables.monotone,
    "alwagih-hindsight": alwagih.hindsight,
    "alwagih-target": alwagih.target,
    "alwagih-tables": alwagih.tables,
    "alwagih-region": alwagih.region,
    "alwagih-ranking": alwagih.ranking,
    "alwagih-significance": alwagih_significance.significance,
    "garg-start": garg.start,
    "garg-lag": garg.lag,
    "garg-precision": garg.precision,
    "garg-gamma": garg.third_gain,
}
"""In the order of the documents and of their errata."""


@cache
def prove(name: str) -> Proof:
    """The proof of that name, computed once.

    Raises:
        InputError: for an unknown name.
    """
    return PROOFS[check_choice("proof", name, PROOFS)]()
