"""python -m trials: what a running server bears and survives, in one table; fails where a bound is broken."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator

from trials import cold, heap, hoard, kills, load, mutate, soak, uploads
from trials.report import Finding, Trial, machine, row

TRIALS: dict[str, Trial] = {
    "load": load.trial,
    "soak": soak.trial,
    "heap": heap.trial,
    "mutate": mutate.trial,
    "uploads": uploads.trial,
    "hoard": hoard.trial,
    "kills": kills.trial,
    "cold": cold.trial,
}


def main() -> int:
    """Run the named trials, or all; say how each came out."""
    parser = argparse.ArgumentParser(prog="python -m trials", description=__doc__)
    parser.add_argument("names", nargs="*", choices=[[], *TRIALS], metavar="|".join(TRIALS), help="all if left out")
    parser.add_argument("--short", action="store_true", help="seconds instead of an hour; no bound on time counts")
    asked = parser.parse_args()
    # The server is started by this process and stays on the same two cores.
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:2])
    print(machine())
    broken = 0
    for name in asked.names or TRIALS:
        for finding in _tried(TRIALS[name], short=asked.short):
            print(row(name, finding), flush=True)
            broken += not finding.held and not (asked.short and finding.timed)
    print(f"{broken} bounds are broken" if broken else "every bound is held")
    return 1 if broken else 0


def _tried(trial: Trial, *, short: bool) -> Iterator[Finding]:
    try:
        yield from trial(short)
    except Exception as error:  # noqa: BLE001 - the other trials are run all the same
        yield Finding("the trial itself", f"{type(error).__name__}: {error}", "no error", held=False)


if __name__ == "__main__":
    sys.exit(main())
