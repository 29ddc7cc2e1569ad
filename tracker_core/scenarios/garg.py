"""Garg's two aircraft, seen by radar every 5 s, with the measured ranges of both editions of the example."""

from __future__ import annotations

from functools import partial

import numpy as np

from tracker_core.scenarios.base import Recording, Scenario
from tracker_core.types import FloatArray

INTERVAL = 5.0
RANGE = 30_000.0
SOURCE = "Garg 2021, alpha-beta(-gamma) filter; the ranges are those of the example at kalmanfilter.net, "


def _accelerating(speed: float, onset: float, acceleration: float, times: FloatArray) -> FloatArray:
    states = np.zeros((len(times), 1, 5))
    since = np.maximum(times - onset, 0)
    states[:, 0, 0] = RANGE + speed * times + acceleration * since**2 / 2
    states[:, 0, 1] = speed + acceleration * since
    states[:, 0, 2] = np.where(times > onset, acceleration, 0)
    return states


def _scenario(name: str, title: str, speed: float, onset: float, text: str, edition: str, ranges: str) -> Scenario:
    accelerates = onset < np.inf
    design = (
        {"order": 3, "alpha": 0.5, "beta": 0.4, "gamma": 0.1}
        if accelerates
        else {"order": 2, "alpha": 0.2, "beta": 0.1}
    )
    return Scenario(
        name=name,
        title=title,
        axes=("range",),
        motion=partial(_accelerating, speed, onset, 8.0 if accelerates else 0.0),
        description=text,
        source=SOURCE + edition,
        first_sample=1,
        defaults={
            "samples": 10,
            "interval": INTERVAL,
            "noise": "recorded",
            "noise_std": (100.0,),
            "start": "known",
            "convention": "taylor",
            "design": "manual",
            **design,
        },
        recording=Recording(np.array([[float(value)] for value in ranges.split()]), INTERVAL),
    )


CONSTANT_VELOCITY = _scenario(
    "garg-constant-velocity",
    "Aircraft at constant velocity (Garg)",
    40.0,
    np.inf,
    "An aircraft 30 km away that recedes at 40 m/s; ten measured ranges.",
    "later edition",
    "30171 30353 30756 30799 31018 31278 31276 31379 31748 32175",
)
CONSTANT_VELOCITY_EARLIER = _scenario(
    "garg-constant-velocity-earlier",
    "Aircraft at constant velocity (Garg, earlier edition)",
    40.0,
    np.inf,
    "An aircraft 30 km away that recedes at 40 m/s; the ten ranges of the earlier edition.",
    "earlier edition",
    "30110 30265 30740 30750 31135 31015 31180 31610 31960 31865",
)
ACCELERATING = _scenario(
    "garg-accelerating",
    "Accelerating aircraft (Garg)",
    50.0,
    20.0,
    "An aircraft 30 km away that recedes at 50 m/s for 20 s and then accelerates by 8 m/s²; ten measured ranges.",
    "later edition",
    "30221 30453 30906 30999 31368 31978 32526 33379 34698 36275",
)
ACCELERATING_EARLIER = _scenario(
    "garg-accelerating-earlier",
    "Accelerating aircraft (Garg, earlier edition)",
    50.0,
    15.0,
    "An aircraft 30 km away that recedes at 50 m/s for 15 s and then accelerates by 8 m/s²; the ten ranges of the "
    "earlier edition. Its 15 s are the onset that fits those ranges best.",
    "earlier edition",
    "30160 30365 30890 31050 31785 32215 33130 34510 36010 37265",
)
