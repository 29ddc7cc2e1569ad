"""Repeatable runs: the same examples every time, and no limit on how long one may take."""

from hypothesis import settings

settings.register_profile("server", derandomize=True, deadline=None, max_examples=100, print_blob=True)
settings.load_profile("server")
