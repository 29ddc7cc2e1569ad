"""Trials of a running server: a load that it must bear, and what it must survive; see __main__.py."""
