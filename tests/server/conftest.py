"""What several test files share: how many examples, and the same ones every time."""

from hypothesis import settings

settings.register_profile("server", derandomize=True, deadline=None, max_examples=200, print_blob=True)
settings.load_profile("server")
