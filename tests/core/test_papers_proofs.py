"""The proofs of the errata: each holds, each is used, and can be shown."""

from __future__ import annotations

import re
from math import isfinite

import pytest

from tracker_core import InputError
from tracker_core.papers import NAMES, papers
from tracker_core.papers.proofs import PROOFS, prove


def test_every_erratum_has_a_proof_and_every_proof_an_erratum():
    assert [name for paper in NAMES for name in proofs_of(paper)] == list(PROOFS)


def proofs_of(paper):
    return [erratum.proof for erratum in papers()[paper].errata]


def test_an_unknown_proof_is_refused():
    with pytest.raises(InputError, match="^proof must be one of jeong-zero-gamma"):
        prove("jeong-perpetual-motion")


@pytest.mark.parametrize("name", PROOFS)
def test_proof_holds_and_can_be_shown(name):
    proof = prove(name)
    assert proof.holds is True
    assert prove(name) is proof
    assert 3 <= len(proof.lines) <= 8
    assert "\n" not in proof.formula
    assert len({title for title, _ in proof.lines}) == len(proof.lines)
    for title, text in proof.lines:
        assert title
        assert text
        # The minus sign is a minus sign.
        assert not re.search(r"-\d|\bnan\b|\binf\b", title + text)
    for series in proof.chart.series if proof.chart else ():
        assert len(series.x) == len(series.y) > 0
        assert all(isfinite(y) for y in series.y)
        assert series.kind in {"line", "points", "bars"}
        assert series.role in {"truth", "observed", "predicted", "smoothed", "counterpart", "marker", "bad"}
