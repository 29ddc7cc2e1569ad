"""The source documents: what they print, and its recomputation."""

from tracker_core.papers.document import NAMES, Erratum, Illustration, Paper, Run, Table, papers
from tracker_core.papers.reproduce import VERDICTS, Outcome, count, reproduce

__all__ = [
    "NAMES", "VERDICTS", "Erratum", "Illustration", "Outcome", "Paper", "Run", "Table", "count", "papers", "reproduce",
]  # fmt: skip
