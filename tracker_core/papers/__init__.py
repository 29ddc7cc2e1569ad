"""The source documents: what they print, and its recomputation."""

from tracker_core.papers.document import NAMES, Paper, Run, papers

__all__ = ["NAMES", "Paper", "Run", "papers"]
