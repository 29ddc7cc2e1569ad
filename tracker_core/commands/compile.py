"""The command `compile`."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from tracker_core.checks import InputError
from tracker_core.commands.base import Commands, print_json


def add(commands: Commands) -> None:
    """Add the command to a parser."""
    parser = commands.add_parser("compile", help="compile all loops now, so that nobody waits for it later")
    parser.add_argument(
        "--level", metavar="NAME", default="native", help="processor: native, or a family: x86-64-v3, x86-64-v4"
    )
    parser.set_defaults(action=_compile)


def _compile(options: argparse.Namespace) -> None:
    from tracker_core.kernels.compiled import ROOT
    from tracker_core.kernels.preparing import Compiled, Preparation
    from tracker_core.kernels.target import named

    target = named(options.level)
    found: list[Compiled] = []

    def note(compiled: Compiled) -> None:
        found.append(compiled)
        if not options.json:
            did = "was there" if compiled.seconds is None else f"{compiled.seconds:.1f} s"
            print(f"{compiled.kernel:20} {did:>10}", flush=True)

    preparation = Preparation(target, ROOT, note)
    preparation.run()
    if preparation.missing:
        raise InputError(
            "level", f"must be one that {', '.join(preparation.missing)} can be compiled for", options.level
        )
    if options.json:
        print_json(_summary(found, target.cpu, str(target.folder(ROOT))))
    else:
        print(f"For {target.cpu} in {target.folder(ROOT)}", file=sys.stdout)


def _summary(found: list[Any], cpu: str, folder: str) -> dict[str, Any]:
    return {"cpu": cpu, "folder": folder, "kernels": {one.kernel: one.seconds for one in found}}
