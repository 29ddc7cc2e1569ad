"""The source documents: what they print, and its recomputation."""

from tracker_core.papers.document import NAMES, Erratum, Illustration, Paper, Run, Table, papers
from tracker_core.papers.proofs import prove
from tracker_core.papers.reproduce import (
    ERRATUM,
    EXACT,
    OPEN,
    SEEDS,
    VERDICTS,
    WITHIN,
    Outcome,
    count,
    prepare,
    reproduce,
)

__all__ = [
    "ERRATUM", "EXACT", "NAMES", "OPEN", "SEEDS", "VERDICTS", "WITHIN", "Erratum", "Illustration", "Outcome", "Paper",
    "Run", "Table", "count", "papers", "prepare", "prove", "reproduce",
]  # fmt: skip
