"""A run as plain data, and plain data as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import isfinite
from typing import Any, TextIO

import numpy as np

from tracker_core.conventions import Gains
from tracker_core.experiment import Experiment
from tracker_core.exports.cells import PIECE, cells
from tracker_core.measured import recorded
from tracker_core.run import Result
from tracker_core.types import GAIN_NAMES, FloatArray, IntArray


def run_summary(result: Result) -> dict[str, Any]:
    """The result of a run as plain data.

    Keys: experiment, gains (convention, alpha ... eta), stable, spectral_radius, metrics, evidence (what the
    innovations say, by name), axes (metrics by axis name), missing, rejected (samples that a gate refused, null without
    one), stopped_at (sample number counted from 1, or null), found (in the file, counts by kind; null for a simulated
    target), method (null for constant gains, else hindsight, found, unstable_share).
    """
    stop, rejected = result.track.stopped_at, result.track.rejected
    return {
        "experiment": result.experiment.to_dict(),
        "gains": gains_dict(result.gains),
        "stable": result.verdict.stable,
        "spectral_radius": result.verdict.spectral_radius,
        "metrics": result.metrics.to_dict(),
        "evidence": result.evidence().to_dict(),
        "axes": {
            axis: metrics.to_dict() for axis, metrics in zip(result.scenario.axes, result.axis_metrics(), strict=True)
        },
        "missing": result.track.missing,
        "rejected": None if rejected is None else int(rejected.sum()),
        "stopped_at": None if stop is None else stop + 1,
        "found": found_in(result.experiment),
        "method": None
        if result.selection is None
        else {
            "hindsight": result.experiment.hindsight or None,
            "found": {name: list(values) for name, values in result.selection.found.items()},
            "unstable_share": result.unstable_share(),
        },
    }


def found_in(experiment: Experiment) -> dict[str, int] | None:
    """What was found in the file that was read, counts by kind of finding; None for a simulated target."""
    if experiment.data is None or experiment.reading is None:
        return None
    return dict(recorded(experiment.data, experiment.reading).counts)


def gains_dict(gains: Gains) -> dict[str, Any]:
    """Convention and gains by name; null for those above the order."""
    padded = [*gains.values, *[None] * (4 - gains.order)]
    return {"convention": gains.convention, **dict(zip(GAIN_NAMES, padded, strict=True))}


def write_json(value: Any, stream: TextIO) -> None:
    """Write plain data and arrays as JSON: every digit, and null for what is not a finite number."""
    json.dump(_plain(value), stream, indent=2, ensure_ascii=False, allow_nan=False)
    stream.write("\n")


def write_columns(columns: Mapping[str, FloatArray | IntArray], stream: TextIO) -> None:
    """Write long columns of equal standing as one JSON object, a column a line: as `write_json`, but piece by piece."""
    for index, (name, column) in enumerate(columns.items()):
        stream.write(f"{',' if index else '{'}\n{json.dumps(name, ensure_ascii=False)}: [")
        pieces = (cells(column[start : start + PIECE], _said) for start in range(0, len(column), PIECE))
        stream.writelines(f"{', ' if number else ''}{', '.join(piece)}" for number, piece in enumerate(pieces))
        stream.write("]")
    stream.write("\n}\n" if columns else "{}\n")


def _said(value: float) -> str:
    return repr(value) if isfinite(value) else "null"


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not isfinite(value) else value
