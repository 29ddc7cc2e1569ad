"""A helper of the server, `python -m layouts.helper FORM LEVEL` with those of its log.

It answers what pages ask until nothing more can come; what it is asked and says is told in server/helpers.py. It has
no recordings and no scenes.
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable
from typing import BinaryIO

from layouts.answering import KINDS, found_by_helper
from layouts.desk import Desk, reader_of
from layouts.pages.compare.answers import DESK as COMPARE
from layouts.pages.data.answers import DESK as DATA
from layouts.pages.explore.answers import DESK as EXPLORE
from layouts.pages.stability.answers import DESK as STABILITY
from layouts.pages.track.answers import DESK as TRACK
from layouts.pages.tune.answers import DESK as TUNE
from server import child
from server.helpers import frame, question_in

DESKS = (EXPLORE, STABILITY, TUNE, COMPARE, DATA, TRACK)


def main() -> None:
    """Answer until the server is gone."""
    form, level = sys.argv[1:]
    out = child.begin(form, level)
    functions = {f"{desk.page} {kind}": _answering(desk, kind) for desk in DESKS for kind in KINDS}
    _say(out, True, b"")
    while (asked := question_in(sys.stdin.buffer.read)) is not None:
        name, question = asked
        try:
            answer = functions[name](question)
        except Exception:  # noqa: BLE001 - the server logs it under the request's number
            _say(out, False, traceback.format_exc().encode())
        else:
            _say(out, True, answer)


def _say(out: BinaryIO, right: bool, answer: bytes) -> None:
    out.write(frame((right, answer)))
    out.flush()


def _answering(desk: Desk, kind: str) -> Callable[[bytes], bytes]:
    read, function = reader_of(desk), found_by_helper(desk, kind)
    return lambda question: function(read(question))


if __name__ == "__main__":
    main()
