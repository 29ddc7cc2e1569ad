"""What a track shows without a truth: against plain sums, and against filters that are known to fit or not."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracker_core import Gains, InputError, Measurements, Track, run_filter
from tracker_core.consistency import average, model_covariance
from tracker_core.innovations import EVIDENCE, Evidence, examine
from tracker_core.optimal import optimal_gains
from tracker_core.whiteness import whiteness

NAN = math.nan
ORDERS = [2, 3, 4]


def tracked(z, gains, interval=1.0, steps=None):
    z = np.asarray(z, dtype=float)
    times = np.arange(len(z)) * interval if steps is None else np.cumsum(steps) * interval
    measurements = Measurements(times, z, interval if steps is None else None)
    return run_filter(measurements, gains), measurements


def gated(track, rejected):
    """The track with some samples rejected."""
    return dataclasses.replace(track, rejected=rejected)


# A filter that fits, and filters that do not -----------------------------------------------------------------------


@pytest.mark.parametrize("order", ORDERS)
def test_the_filter_of_the_model_is_above_suspicion(pushed_target, order):
    z = pushed_target(order, np.ones(4000), 0.3, 5.0, np.random.default_rng(order + 1), axes=2)
    gains = Gains.normalised(optimal_gains(order, 0.3))
    found = examine(*tracked(z, gains), gains, sensor_std=(5.0,), tracking_index=0.3)
    assert found.nis.holds
    assert found.nis.mean == pytest.approx(2, rel=0.08)
    assert found.whiteness.probability > 0.01
    assert abs(found.bias) < 3.5 * found.bias_error
    assert found.rmse == pytest.approx(5 * math.sqrt(2 * model_covariance(gains, 0.3).innovation), rel=0.05)
    for axis in found.axes:
        assert axis.nis.mean == pytest.approx(1, rel=0.1)
        assert axis.whiteness.probability > 0.005


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("index", [0.003, 30.0], ids=["sluggish", "nervous"])
def test_a_filter_of_another_model_is_found_out(pushed_target, order, index):
    z = pushed_target(order, np.ones(3000), 0.3, 5.0, np.random.default_rng(order), axes=1)
    gains = Gains.normalised(optimal_gains(order, index))
    found = examine(*tracked(z, gains), gains, sensor_std=(5.0,), tracking_index=index)
    assert found.whiteness.probability < 1e-6
    assert not found.nis.holds


def test_a_filter_that_trails_shows_a_bias():
    t = np.arange(300.0)
    z = 0.5 * 2 * t[:, None] ** 2 + np.random.default_rng(0).normal(0, 1, (300, 1))
    gains = Gains((0.4, 0.1))
    found = examine(*tracked(z, gains), gains)
    # The steady lag of the prediction is T^2 A/beta.
    assert found.bias == pytest.approx(2 / 0.1, abs=4 * found.bias_error)
    assert found.axes[0].bias == found.bias > 10 * found.bias_error


# The figures -------------------------------------------------------------------------------------------------------


@given(
    z=st.lists(st.lists(st.floats(-100, 100) | st.just(NAN), min_size=2, max_size=2), min_size=8, max_size=30),
    data=st.data(),
)
def test_figures_by_plain_sums(z, data):
    n = len(z)
    z = np.array(z)
    innovation = np.array(data.draw(st.lists(st.floats(-9, 9), min_size=2 * n, max_size=2 * n))).reshape(n, 2)
    innovation[np.isnan(z)] = NAN
    rejected = np.array(data.draw(st.lists(st.booleans(), min_size=n, max_size=n)))
    smoothed = np.random.default_rng(0).normal(size=(n, 2, 2))
    track = Track(smoothed, smoothed, innovation, 0, None, 1e12, rejected)
    found = examine(track, Measurements(np.arange(n) * 2.0, z, 2.0), Gains((0.5, 0.2)), skip=0)
    kept = [e for e, out in zip(innovation.tolist(), rejected, strict=True) if not out]
    lengths = [math.hypot(*e) for e in kept if not any(map(math.isnan, e))]
    assert found.count == len(lengths)
    if lengths:
        assert found.rmse == pytest.approx(math.sqrt(math.fsum(v * v for v in lengths) / len(lengths)))
        assert found.greatest == pytest.approx(max(lengths))
    else:
        assert found.rmse is found.greatest is None
    measured = [not all(map(math.isnan, row)) for row in z.tolist()]
    wrong = sum(1 for seen, out in zip(measured, rejected, strict=True) if seen and out)
    assert found.rejected == pytest.approx(wrong / max(1, sum(measured)))
    means = []
    for axis in range(2):
        own = [e[axis] for e in kept if not math.isnan(e[axis])]
        assert found.axes[axis].count == len(own)
        assert found.axes[axis].bias == (pytest.approx(math.fsum(own) / len(own), abs=1e-9) if own else None)
        means.append(found.axes[axis].bias)
    assert found.bias == (None if None in means else pytest.approx(math.hypot(*means)))


def test_jerkiness_is_the_acceleration_along_the_path():
    t = np.arange(50) * 0.5
    gains = Gains((0.5, 0.2, 0.05))
    track, measurements = tracked(np.c_[t**2, -3 * t], gains, 0.5)
    found = examine(track, measurements, gains)
    assert found.roughness == pytest.approx(2)
    assert found.axes[1].roughness == pytest.approx(0, abs=1e-9)
    path = track.smoothed[:, :, 0]
    second = (path[2:] - 2 * path[1:-1] + path[:-2]) / 0.25
    assert found.smoothness == pytest.approx(math.sqrt(np.nanmean((second**2).sum(axis=1))))
    assert found.smoother == pytest.approx(found.roughness / found.smoothness)


def test_jerkiness_over_varying_intervals():
    steps = np.random.default_rng(0).uniform(0.2, 3, 60)
    t = np.cumsum(steps)
    gains = Gains((0.5, 0.2))
    found = examine(*tracked(1.5 * t[:, None] ** 2, gains, 1.0, steps), gains)
    assert found.roughness == pytest.approx(3)


def test_smoothing_smooths(pushed_target):
    z = pushed_target(2, np.ones(500), 0.01, 1.0, np.random.default_rng(0))
    gains = Gains.normalised(optimal_gains(2, 0.01))
    assert examine(*tracked(z, gains), gains).smoother > 5


def test_rejected_samples_do_not_count(pushed_target):
    z = pushed_target(2, np.ones(300), 0.3, 1.0, np.random.default_rng(0))
    gains = Gains.normalised(optimal_gains(2, 0.3))
    track, measurements = tracked(z, gains)
    rejected = np.zeros(300, dtype=bool)
    rejected[[50, 60]] = True
    innovation = np.where(rejected[:, None], 1e6, track.innovation)
    found = examine(gated(dataclasses.replace(track, innovation=innovation), rejected), measurements, gains)
    assert found.greatest < 100
    assert found.rejected == 2 / 300
    assert found.count == 298 - 2
    assert found.to_dict()["rejected"] == pytest.approx(100 * 2 / 300)


def test_the_start_is_left_out_of_what_supposes_a_steady_filter(pushed_target):
    z = pushed_target(2, np.ones(400), 0.3, 1.0, np.random.default_rng(0))
    gains = Gains.normalised(optimal_gains(2, 0.3))
    track, measurements = tracked(z, gains)
    variance = model_covariance(gains, 0.3).innovation
    for skip in (0, 10, 77):
        found = examine(track, measurements, gains, sensor_std=(1.0,), tracking_index=0.3, skip=skip)
        late = track.innovation[skip:]
        assert found.nis == average(late[:, 0] ** 2 / variance, 1)
        assert found.axes[0].whiteness.statistic == whiteness(late[:, 0]).statistic
        assert found.count == 398
    # By default until a twentieth is left of the start: 0.72^10 = 0.04.
    default = examine(track, measurements, gains, sensor_std=(1.0,), tracking_index=0.3)
    slowest = abs(np.roots([1, sum(gains.values[:2]) - 2, 1 - gains.values[0]])).max()
    assert default.nis.count == 400 - math.ceil(math.log(0.05) / math.log(slowest))


@pytest.mark.parametrize("steady", [True, False])
def test_gains_that_are_not_optimal_widen_the_interval_of_nis(pushed_target, steady):
    z = pushed_target(2, np.ones(300), 0.3, 2.0, np.random.default_rng(0), axes=2)
    gains = Gains((0.3, 0.2))
    track, measurements = tracked(z, gains)
    model = model_covariance(gains, 0.3)
    assert model.correlation > 0.1
    spread = None if steady else np.full(z.shape, 2 * math.sqrt(model.innovation))
    found = examine(track, measurements, gains, sensor_std=(2.0,), tracking_index=0.3, spread=spread, skip=50)
    values = (track.innovation[50:] / 2) ** 2 / model.innovation
    wanted = average(values.sum(axis=1), 2, correlation=model.correlation)
    for name in ("mean", "low", "high", "count"):
        assert getattr(found.nis, name) == pytest.approx(getattr(wanted, name), rel=1e-12)


@pytest.mark.parametrize("gains", [Gains((0.5, 3.5)), Gains((1.0, 1.0)), Gains((0.001, 1e-6))], ids=str)
def test_no_gains_break_it(gains):
    z = np.random.default_rng(0).normal(size=(40, 2))
    found = examine(*tracked(z, gains), gains, sensor_std=(1.0, 2.0), tracking_index=0.1)
    assert all(value is None or math.isfinite(value) for value in found.to_dict().values())


@pytest.mark.parametrize("std", [None, (0.0, 1.0), (0.0,)])
def test_without_a_model_there_is_no_nis(std):
    gains = Gains((0.5, 0.2))
    found = examine(*tracked(np.random.default_rng(0).normal(size=(40, 2)), gains), gains, sensor_std=std,
                    tracking_index=0.1)  # fmt: skip
    assert found.nis is None
    assert found.to_dict()["nis"] is None
    assert found.whiteness is not None


def test_a_track_of_nothing():
    z = np.full((6, 1), NAN)
    states = np.full((6, 1, 2), NAN)
    found = examine(Track(states, states, z, 0, None, 1e12), Measurements(np.arange(6.0), z, 1.0), Gains((0.5, 0.2)),
                    sensor_std=(1.0,), tracking_index=0.1)  # fmt: skip
    assert set(found.to_dict()) == set(EVIDENCE)
    assert {name for name, value in found.to_dict().items() if value is not None} == {"rejected"}
    assert (found.count, found.rejected, found.smoother) == (0, 0.0, None)


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"sensor_std": (1.0, 2.0, 3.0), "tracking_index": 0.1}, "sensor_std"),
        ({"sensor_std": (-1.0,), "tracking_index": 0.1}, "sensor_std"),
        ({"sensor_std": (1.0,), "tracking_index": -0.1}, "tracking_index"),
        ({"skip": -1}, "skip"),
        ({"lags": 0}, "lags"),
    ],
    ids=str,
)
def test_what_cannot_be_is_refused(given, field):
    gains = Gains((0.5, 0.2))
    with pytest.raises(InputError) as caught:
        examine(*tracked(np.zeros((40, 2)), gains), gains, **given)
    assert caught.value.field == field


def test_every_figure_is_described():
    assert set(EVIDENCE) == set(Evidence(0, *[None] * 8, 0.0).to_dict())
    assert all(metric.title and metric.sentence.endswith(".") and metric.formula for metric in EVIDENCE.values())
