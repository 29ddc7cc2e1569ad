"""Writes the made recordings in assets/recordings/: `python scripts/recordings.py`. A test fails when they are stale.

Vessels, aircraft and their numbers are made up.
"""

from __future__ import annotations

import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
TARGET = ROOT / "assets" / "recordings"

METRES = 111_132.0  # in a degree of latitude, near enough for a made-up place


def good() -> str:
    """A target that flies straight, turns and flies straight again: every 0.1 s, sensor of 5 m, with its truth."""
    draw = np.random.default_rng(1)
    rate = np.zeros(400)
    rate[120:260] = np.deg2rad(9)  # rad/s
    heading = np.deg2rad(30) + np.cumsum(rate) * 0.1
    truth = np.cumsum(60 * 0.1 * np.stack((np.cos(heading), np.sin(heading)), axis=1), axis=0)
    measured = truth + 5 * draw.standard_normal(truth.shape)
    rows = (
        f"{0.1 * k:.1f},{z[0]:.3f},{z[1]:.3f},{p[0]:.3f},{p[1]:.3f}"
        for k, (z, p) in enumerate(zip(measured, truth, strict=True))
    )
    return "\n".join(["t,x,y,x_true,y_true", *rows]) + "\n"


def irregular() -> str:
    """Two vessels as AIS gives them: reports every two to thirteen seconds, now and then none for a minute."""
    draw = np.random.default_rng(2)
    begin = datetime(2024, 5, 4, 6, 30, tzinfo=UTC)
    reports = []
    for number, name, latitude, longitude, begun, speed, count in (
        ("211000101", "VESSEL A", 54.18, 7.85, 70.0, 8.2, 300),
        ("211000202", "VESSEL B", 54.24, 7.99, 215.0, 5.1, 220),
    ):
        place = np.array([latitude, longitude])
        second, course = 0, begun
        for k in range(count):
            step = int(draw.integers(2, 14)) + (60 if draw.random() < 0.02 else 0)
            second += step
            course += float(draw.normal(0.4 if 80 < k < 160 else 0, 0.15)) * step / 4
            direction = np.deg2rad(course)
            move = speed * step * np.array([np.cos(direction), np.sin(direction) / np.cos(np.deg2rad(latitude))])
            place = place + move / METRES
            seen = place + draw.normal(0, 6, 2) / METRES
            stamp = (begin + timedelta(seconds=second)).strftime("%Y-%m-%dT%H:%M:%S")
            knots, degrees = speed * 3.6 / 1.852, course % 360
            reports.append((second, f"{number},{stamp},{seen[0]:.5f},{seen[1]:.5f},{knots:.1f},{degrees:.1f},{name}"))
    reports.sort()
    return "\n".join(["MMSI,BaseDateTime,LAT,LON,SOG,COG,VesselName", *(line for _, line in reports)]) + "\n"


def dirty() -> str:
    """A landing as ADS-B gives it at one report a second, with all that goes wrong in such logs."""
    draw = np.random.default_rng(3)
    count = 420
    speed = np.interp(np.arange(count), [0, 250, 330, 400, count], [105, 75, 68, 15, 10])  # m/s
    along = np.concatenate(([0.0], np.cumsum(speed)[:-1]))
    runway = np.deg2rad(82)
    height = np.maximum((along[330] - along) * np.tan(np.deg2rad(3)), 0) + 450  # of the ground: 450 m
    latitude = 48.32 + (along * np.cos(runway) + draw.normal(0, 12, count)) / METRES
    longitude = 11.4 + (along * np.sin(runway) + draw.normal(0, 12, count)) / METRES / np.cos(np.deg2rad(48.32))
    feet = 25 * np.round((height / 0.3048 + draw.normal(0, 10, count)) / 25)

    for k in draw.choice(np.arange(20, count), 9, replace=False):
        latitude[k] += draw.choice([-1, 1]) * draw.uniform(0.008, 0.04)
    for k in sorted(draw.choice(np.arange(30, 400), 26, replace=False)):
        latitude[k], longitude[k], feet[k] = latitude[k - 1], longitude[k - 1], feet[k - 1]
    rows = [
        f"{1714800000 + k},3fff01,{latitude[k]:.5f},{longitude[k]:.5f},{feet[k]:.0f}"
        for k in range(count)
        if not (75 <= k < 83 or 190 <= k < 194 or 301 <= k < 306)
    ]

    def change(row: int, column: int, value: str) -> None:
        cells = rows[row].split(",")
        cells[column] = value
        rows[row] = ",".join(cells)

    change(12, 2, "ERR")
    change(47, 4, "#VALUE!")
    change(133, 3, "")
    change(210, 0, "?")
    change(260, 2, "=1+1")
    change(318, 2, "91.0")
    rows[160], rows[163] = rows[163], rows[160]
    for k in (330, 240, 99, 41):
        rows.insert(k + 1, rows[k])
    rows.insert(285, rows[284].rpartition(",")[0] + ",9999")
    rows.insert(150, "# receiver restarted")
    return "\n".join(["# ADS-B, altitude in feet", "time,icao24,lat,lon,altitude", *rows]) + "\n"


RECORDINGS = {"good.csv": good, "irregular.csv": irregular, "dirty.csv": dirty}


def main() -> int:
    TARGET.mkdir(exist_ok=True)
    for name, written in RECORDINGS.items():
        (TARGET / name).write_text(written(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
