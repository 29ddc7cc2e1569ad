"""Clocks against the standard library and by hand; intervals that are constant, and those that are not."""

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from tracker_core.recordings import Reading, read
from tracker_core.recordings.clocks import CLOCKS, microseconds, second_of_day, start_of, unroll
from tracker_core.recordings.timing import _distance, _evenest, find_grid, regularity


def times_of(cells, **reading):
    rows = [f"{cell};{k}" for k, cell in enumerate(cells)]
    return read("\n".join(["t;x", *rows]).encode(), Reading(delimiter="semicolon", at=(2,), **reading))


# Clocks --------------------------------------------------------------------------------------------------------------

ZONES = st.integers(-14 * 60, 14 * 60).map(lambda minutes: timezone(timedelta(minutes=minutes)))


@given(st.datetimes(min_value=datetime(1, 1, 3), max_value=datetime(9999, 12, 29), timezones=ZONES))  # noqa: DTZ001
def test_a_date_is_read_as_the_library_reads_it(stamp):
    expected = (stamp - datetime(1970, 1, 1, tzinfo=UTC)) // timedelta(microseconds=1)
    assert microseconds(stamp.isoformat()) == pytest.approx(expected, abs=0 if abs(expected) < 2**53 else 64)


@pytest.mark.parametrize(
    "cell",
    [
        "2024-02-29T23:59:59.250Z", "2024-02-29 23:59:59.25+00:00", "2024-03-01T01:59:59.25+02:00",
        "2024-02-29T18:29:59.250000-05:30", "2024-02-29 23:59:59.25", " 2024-02-29 23:59:59.25 UTC ",
        "2024/02/29 23:59:59.25", "20240229T235959.25Z", "2024-02-29T23:59:59,25Z",
    ],
)  # fmt: skip
def test_spellings_of_one_instant(cell):
    assert microseconds(cell) == datetime(2024, 2, 29, 23, 59, 59, 250_000, tzinfo=UTC).timestamp() * 1e6


@pytest.mark.parametrize(
    "cell", ["", "now", "2024-02-30", "2024-13-01T00:00", "12:00:00", "NaT", "2024-01-01T24:00:01"]
)
def test_no_dates(cell):
    assert np.isnan(microseconds(cell))


@pytest.mark.parametrize(
    ("cell", "seconds"),
    [
        ("000000", 0), ("123519", 45319), ("123519.25", 45319.25), ("12:35:19.25", 45319.25), (" 1:02:03 ", 3723),
        ("10203", 3723), ("235960", 86400), ("23:59:59.", 86399),
    ],
)  # fmt: skip
def test_times_of_day(cell, seconds):
    assert second_of_day(cell) == seconds


@pytest.mark.parametrize(
    "cell", ["", "240000", "126000", "12:60:00", "12:00:61", "12:0:0", "1200", "12:0000", "-010203"]
)
def test_no_times_of_day(cell):
    assert np.isnan(second_of_day(cell))


def test_days_are_told_apart_by_their_midnights():
    day = 86_400
    assert unroll(np.array([day - 2.0, day - 1.0, 0.0, 1.0])).tolist() == [day - 2, day - 1, day, day + 1]
    assert unroll(np.array([day - 2.0, 1.0, day - 1.0, 2.0])).tolist() == [day - 2, day + 1, day - 1, day + 2]
    assert unroll(np.array([1.0, day - 1.0])).tolist() == [1, day - 1]
    assert unroll(np.array([10.0, 5.0])).tolist() == [10, 5]
    assert unroll(np.array([])).tolist() == []


def test_a_recording_over_two_midnights():
    seconds = np.arange(0, 3 * 86_400, 3600) + 43_000
    cells = [f"{s // 3600 % 24:02d}{s // 60 % 60:02d}{s % 60:02d}" for s in seconds]
    found = times_of(cells, clock="hms")
    assert found.times.tolist() == (seconds - seconds[0]).tolist()
    assert found.start == ""


@pytest.mark.parametrize(
    ("clock", "cells"),
    [
        ("seconds", ["1714800000", "1714800000.5", "1714800001"]),
        ("milliseconds", ["1714800000000", "1714800000500", "1714800001000"]),
        ("microseconds", ["1714800000000000", "1714800000500000", "1714800001000000"]),
        ("iso", ["2024-05-04T05:20:00Z", "2024-05-04T07:20:00.5+02:00", "2024-05-04 05:20:01"]),
    ],
)
def test_clocks_agree(clock, cells):
    found = times_of(cells, clock=clock)
    assert found.times.tolist() == [0, 0.5, 1]
    assert found.start == "2024-05-04 05:20:00 UTC"


def test_no_digit_of_a_date_is_lost():
    found = times_of([f"2024-05-04T05:20:00.{k:06d}Z" for k in (1, 2, 3, 5, 90)], clock="iso")
    assert found.times[1] == 1e-6
    assert found.interval == 1e-6
    assert len(found.times) == 90


def test_start_is_told_where_it_is_known():
    assert start_of("seconds", 12.0) == ""
    assert start_of("hms", 1e9) == ""
    assert start_of("seconds", 1e11) == "5138-11-16 09:46:40 UTC"
    assert start_of("iso", 1.25e6) == "1970-01-01 00:00:01.250 UTC"
    assert start_of("iso", 1e30) == ""
    assert list(CLOCKS) == ["seconds", "milliseconds", "microseconds", "iso", "hms"]


# Intervals -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("interval", [1.0, 0.1, 0.04, 1 / 3, 2.5, 0.0123456789, 12.0, 1e-4, 3600.0])
@pytest.mark.parametrize("gaps", [False, True])
def test_a_constant_interval_is_found_to_the_last_digits(interval, gaps):
    samples = np.arange(5000)
    if gaps:
        samples = np.sort(np.random.default_rng(4).choice(samples, 3000, replace=False))
        samples = np.concatenate((samples - samples[0], samples[-1] - samples[0] + [1, 501]))
    grid = find_grid(samples * interval)
    assert grid.interval == pytest.approx(interval, rel=1e-13)
    assert np.array_equal(grid.samples, samples)


@pytest.mark.parametrize(
    ("interval", "decimals"),
    [(1 / 3, 3), (0.04, 2), (1 / 30, 3), (1 / 24, 3), (0.7, 1), (4.8, 0), (5.2, 0), (0.016, 3)],
)
@pytest.mark.parametrize("offset", [0.0, 1_714_800_000.0])
def test_stamps_that_were_rounded_are_constant(interval, decimals, offset):
    stamps = np.round(offset + np.arange(2000) * interval, decimals)
    grid = find_grid(stamps - stamps[0], stamps[0])
    assert np.array_equal(grid.samples, np.arange(2000))
    assert grid.interval == pytest.approx(interval, rel=10.0**-decimals / 2000 / interval)


def test_the_interval_of_fewest_digits_is_taken():
    assert find_grid(np.cumsum(np.full(50, 0.1)) - 0.1).interval == 0.1
    stamps = np.round(np.arange(999) / 3, 3)
    assert find_grid(stamps).interval == pytest.approx(1 / 3, abs=1e-6)


@pytest.mark.parametrize("kept", [1.0, 0.8], ids=["whole", "with gaps"])
@pytest.mark.parametrize("seed", range(60))
def test_stamps_are_constant_however_they_were_rounded(seed, kept):
    """Half a unit of the last decimal is 1 to 10 % of the interval; a third lie further from the least squares."""
    draw = np.random.default_rng(seed)
    unit = 10.0 ** -draw.integers(0, 4)
    interval = 0.5 * unit / draw.uniform(0.01, 0.0999)
    samples = np.sort(draw.choice(2000, int(2000 * kept), replace=False))
    samples -= samples[0]
    stamps = np.round((draw.uniform(0, 1000) + interval * samples) / unit) * unit
    grid = find_grid(stamps - stamps[0], stamps[0])
    assert np.array_equal(grid.samples, samples)
    assert grid.interval == pytest.approx(interval, rel=2 * unit / interval / samples[-1])


def evenest_by_programme(samples, times):
    """Interval and greatest distance: the least d with |t - a - k T| <= d for every stamp."""
    ones = np.ones_like(samples)
    sides = np.vstack([np.column_stack([-ones, -samples, -ones]), np.column_stack([ones, samples, -ones])])
    found = linprog(
        [0, 0, 1], A_ub=sides, b_ub=np.concatenate((-times, times)), bounds=[(None, None)] * 2 + [(0, None)]
    )
    assert found.status == 0
    return found.x[1], found.x[2]


@given(st.lists(st.tuples(st.integers(1, 30), st.floats(0.5, 20)), min_size=1, max_size=60))
def test_the_evenest_interval_is_that_of_a_linear_programme(steps):
    samples, times = (np.concatenate(([0.0], np.cumsum(part))) for part in zip(*steps, strict=True))
    interval = _evenest(samples, times)
    _, least = evenest_by_programme(samples, times)
    assert _distance(samples, times, interval) == pytest.approx(least, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize(
    ("samples", "times"),
    [
        (np.arange(2.0), np.array([0, 3.7])),
        (np.arange(3000.0), np.round(np.arange(3000) / 7, 2)),
        (np.arange(3000.0), np.arange(3000) * 0.1),
        (np.arange(3000.0), 0.1 * np.arange(3000) + 1e-7 * np.arange(3000) ** 2),
        (np.arange(3000.0) ** 1.5 // 1 + np.arange(3000), np.arange(3000.0)),
        (np.arange(500.0), np.concatenate((np.arange(499) * 1e-6, [1e6]))),
    ],
    ids=["two", "rounded", "exact", "drift", "slower", "one far away"],
)
def test_the_evenest_interval_of_long_recordings(samples, times):
    interval, least = evenest_by_programme(samples, times)
    found = _evenest(samples, times)
    assert _distance(samples, times, found) == pytest.approx(least, rel=1e-7, abs=1e-9 * times[-1])
    # Its neighbours are no better.
    for nearby in (found * (1 - 1e-6), found * (1 + 1e-6), interval):
        assert _distance(samples, times, nearby) >= _distance(samples, times, found) - 1e-12 * times[-1]


@pytest.mark.parametrize("share", [0.002, 0.008])
def test_a_little_jitter_is_constant(share):
    draw = np.random.default_rng(6)
    times = np.arange(500) * 0.2 + draw.uniform(-share, share, 500) * 0.2
    grid = find_grid(times - times[0])
    assert np.array_equal(grid.samples, np.arange(500))
    assert grid.interval == pytest.approx(0.2, rel=1e-4)


def drifting(k):
    return 0.1 * k + 1e-7 * k**2


@pytest.mark.parametrize(
    "times",
    [
        np.arange(500) * 0.2 + np.random.default_rng(7).uniform(-0.05, 0.05, 500) * 0.2,
        drifting(np.arange(1000)),
        np.cumsum(np.random.default_rng(8).integers(2, 14, 300)).astype(float),
        np.cumsum(np.random.default_rng(9).exponential(1, 300)),
        np.array([0, 1, 2, 3, 4.5, 5.5, 6.5, 7.5]),
        np.arange(100.0) ** 2,
        np.array([0, 1e-300, 1.0, 2.0]),
        np.array([0, 1.0, 1e11]),
        np.cumsum([0, *[2, 3] * 20]).astype(float),
        np.round(np.arange(500) * 2.4),
    ],
    ids=["jitter", "drift", "whole seconds", "at random", "a step", "growing", "tiny", "huge", "2, 3, 2, 3", "2.4"],
)
def test_not_constant(times):
    assert find_grid(times - times[0]) is None


def test_how_even_it_is():
    even = regularity(np.array([0, 1, 2, 4, 5.2, 6.2]), None)
    assert (even.nominal, even.shortest, even.longest) == pytest.approx((1, 1, 2))
    assert even.odd == 0.2
    assert even.jitter == pytest.approx(0.2 / 5**0.5)
    assert even.aside == 0
    assert regularity(np.arange(9) * 0.1, 0.1).odd == 0


@pytest.mark.parametrize(("interval", "constant"), [(11.2, True), (4.2, True), (3.8, False), (2.2, False)])
def test_rounding_is_admitted_to_a_tenth_of_the_interval(interval, constant):
    """In whole seconds all of these lie up to 0.4 s beside their samples."""
    stamps = np.round(np.arange(500) * interval)
    assert np.ptp(stamps - np.arange(500) * interval) / 2 == pytest.approx(0.4)
    assert (find_grid(stamps) is not None) == constant


def test_how_far_stamps_lie_beside_their_samples():
    stamps = np.floor(np.arange(300) * 5.5 + 0.5)
    grid = find_grid(stamps)
    expected = stamps - grid.interval * np.arange(300)
    found = regularity(stamps, grid.interval)
    assert found.aside == pytest.approx(np.ptp(expected) / 2)
    assert found.aside == pytest.approx(0.25, rel=1e-6)
    with_gap = np.delete(stamps, np.arange(100, 140))
    assert regularity(with_gap, grid.interval).aside == pytest.approx(0.25, rel=1e-6)
    assert regularity(np.arange(300) / 3, 1 / 3).aside < 1e-12


@pytest.mark.parametrize("start", [0, 1_714_800_000])
def test_true_whole_seconds_keep_a_line_straight(start):
    """Stamps 2, 3, 2, 3 s apart that are true: taken as every 2.5 s they would bend a straight line."""
    times = np.cumsum([0, *[2, 3] * 20])
    found = read("\n".join(["t,x", *(f"{start + t},{250 * t}" for t in times)]).encode(), Reading(at=(2,)))
    assert found.interval is None
    assert found.times.tolist() == times.tolist()
    assert found.positions[:, 0].tolist() == (250.0 * times).tolist()


@given(
    st.floats(1e-3, 1e3),
    st.lists(st.integers(1, 40), min_size=2, max_size=60),
)
def test_sample_numbers_come_back(interval, steps):
    samples = np.concatenate(([0], np.cumsum(steps)))
    grid = find_grid(samples * interval)
    if grid is None:
        # The usual interval is not one sample: the grid is not found, and the intervals are used as they are.
        assert np.median(steps) > 1
    else:
        assert grid.interval * grid.samples == pytest.approx(samples * interval, rel=1e-9)
