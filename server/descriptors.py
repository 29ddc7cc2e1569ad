"""Descriptors, of which every socket and every open file takes one: that there are as many as the settings need.

A process usually begins with 1,024, and may have more once it asks. One that has none left hears nobody, and can
neither read a file nor start another process.
"""

from __future__ import annotations

import contextlib
import logging
import resource

from server.entrance import most_connections
from server.settings import Settings

OF_A_SCENE = 2
"""Beside the socket of the browser: both ends of the connection between the proxy of the scenes and viser."""

OF_A_HELPER = 3
"""Two pipes, and what tells of its end."""

OTHERS = 300
"""The server's own, recordings that come in, and files that are being read."""

_LOG = logging.getLogger(__name__)


def needed(settings: Settings) -> int:
    """How many are open where everything is that may be."""
    scenes, helpers = OF_A_SCENE * settings.scenes, OF_A_HELPER * settings.helpers
    return most_connections(settings) + scenes + helpers + OTHERS


def provide(settings: Settings) -> int:
    """Have as many as the settings need, or as the machine allows; what is too few for them is said in the log.

    Returns:
        How many there may be, of this process and of each that it starts from now on; negative where any number.
    """
    wanted = needed(settings)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if _is_less(soft, wanted):
        soft = hard if _is_less(hard, wanted) else wanted
        # Some systems have another limit beside the hard one.
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))
        soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    if _is_less(soft, wanted):
        _LOG.warning(
            "Not as many files and sockets may be open as GAINSCOPE_SOCKETS and GAINSCOPE_SCENES need: %d of %d. The "
            "hard limit (ulimit -Hn) must be higher, or they lower", soft, wanted,
        )  # fmt: skip
    return soft


def _is_less(limit: int, wanted: int) -> bool:
    return limit != resource.RLIM_INFINITY and limit < wanted
