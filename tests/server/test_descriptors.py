"""Files and sockets that may be open: as many as the settings need, as far as the machine allows."""

import resource
from dataclasses import replace

import pytest

from server import descriptors
from server.descriptors import OF_A_HELPER, OF_A_SCENE, needed, provide
from server.settings import Settings

INFINITE = resource.RLIM_INFINITY
SETTINGS = Settings(sockets=5000, scenes=100, helpers=2)
NEEDED = needed(SETTINGS)


@pytest.mark.parametrize(("name", "each"), [("sockets", 1), ("scenes", OF_A_SCENE), ("helpers", OF_A_HELPER)])
def test_what_is_needed_follows_the_settings(name, each):
    more = replace(SETTINGS, **{name: getattr(SETTINGS, name) + 7})
    assert needed(more) == NEEDED + 7 * each


@pytest.mark.parametrize(
    ("soft", "hard", "own", "comes_to"),
    [
        (1024, 524_288, INFINITE, NEEDED),
        (1024, INFINITE, INFINITE, NEEDED),
        (1024, NEEDED, INFINITE, NEEDED),
        (1024, 4096, INFINITE, 4096),
        (256, INFINITE, 4096, 256),
        (1_000_000, 1_000_000, INFINITE, 1_000_000),
        (INFINITE, INFINITE, INFINITE, INFINITE),
    ],
    ids=["a container", "no limit", "just enough", "too little", "another limit", "more", "everything"],
)
def test_the_limit_is_raised_as_far_as_it_may_be(monkeypatch, caplog, soft, hard, own, comes_to):
    limits = [soft, hard]

    def change(kind, wanted):
        assert kind == resource.RLIMIT_NOFILE
        assert wanted[1] == hard
        assert INFINITE in (own, hard) or wanted[0] <= hard
        if own != INFINITE and wanted[0] > own:
            raise ValueError("current limit exceeds maximum limit")
        limits[0] = wanted[0]

    monkeypatch.setattr(descriptors.resource, "getrlimit", lambda kind: tuple(limits))
    monkeypatch.setattr(descriptors.resource, "setrlimit", change)
    assert provide(SETTINGS) == limits[0] == comes_to
    is_enough = comes_to in (INFINITE, 1_000_000, NEEDED)
    said = [f"{comes_to} of {NEEDED}" in record.getMessage() for record in caplog.records]
    assert said == ([] if is_enough else [True])


def test_this_machine_is_asked():
    few, (soft, hard) = 1024, resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != INFINITE and hard <= few:
        pytest.skip("it has no more than that")
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (few, hard))
        assert few < provide(SETTINGS) == resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
