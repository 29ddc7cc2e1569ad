"""The short version of the trials of a running server: the same code, smaller numbers, no bound on time."""

import pytest

from trials.__main__ import TRIALS

NAMES = [name for name in TRIALS if name != "heap"]
"""The one with a browser is among the browser's tests."""


@pytest.mark.parametrize("name", NAMES)
def test_a_server_bears_and_survives_it(name):
    findings = list(TRIALS[name](True))
    assert findings
    assert [finding for finding in findings if not (finding.held or finding.timed)] == []
