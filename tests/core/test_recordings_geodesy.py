"""Local east, north and up against earth-centred coordinates by mpmath, to a millimetre over 100 km."""

import math

import mpmath
import numpy as np
import pytest

from tracker_core.recordings import Reading, read
from tracker_core.recordings.geodesy import to_local

FLATTENING = 1 / mpmath.mpf("298.257223563")  # WGS 84
EQUATOR = mpmath.mpf(6378137)


def earth_centred(latitude, longitude, altitude):
    """From Hofmann-Wellenhof, GNSS, equation 8.3, with 40 digits."""
    with mpmath.workdps(40):
        phi, lam = mpmath.radians(mpmath.mpf(latitude)), mpmath.radians(mpmath.mpf(longitude))
        squeeze = FLATTENING * (2 - FLATTENING)
        normal = EQUATOR / mpmath.sqrt(1 - squeeze * mpmath.sin(phi) ** 2)
        flat = (normal + altitude) * mpmath.cos(phi)
        up = (normal * (1 - squeeze) + altitude) * mpmath.sin(phi)
        return mpmath.matrix([flat * mpmath.cos(lam), flat * mpmath.sin(lam), up])


def local(place, origin):
    """The difference, turned by the textbook matrix of the origin."""
    with mpmath.workdps(40):
        x, y, z = earth_centred(*place) - earth_centred(*origin)
        phi, lam = mpmath.radians(mpmath.mpf(origin[0])), mpmath.radians(mpmath.mpf(origin[1]))
        s, c, t, d = mpmath.sin(lam), mpmath.cos(lam), mpmath.sin(phi), mpmath.cos(phi)
        east = -s * x + c * y
        north = -t * c * x - t * s * y + d * z
        up = d * c * x + d * s * y + t * z
        return [float(east), float(north), float(up)]


ORIGINS = {
    "middle": (48.3, 11.4, 450.0),
    "equator": (0.0, 0.0, 0.0),
    "near the north pole": (89.9, 17.0, 20.0),
    "at the north pole": (90.0, 0.0, 0.0),
    "near the south pole": (-89.95, -120.0, 2800.0),
    "east of the date line": (-16.8, -179.95, 10.0),
    "west of the date line": (52.0, 179.9, 10_000.0),
    "in the 360 degree count": (10.0, 359.99, 0.0),
}


def track_around(origin):
    """Places on 100 km through the origin, across whatever is there."""
    draw = np.random.default_rng(5)
    latitude = origin[0] + np.linspace(-0.45, 0.45, 41)
    over = np.abs(latitude) > 90
    latitude = np.where(over, np.sign(latitude) * 180 - latitude, latitude)
    spread = min(0.45 / max(math.cos(math.radians(origin[0])), 1e-9), 170.0)
    longitude = origin[1] + np.linspace(-spread, spread, 41) + 180 * over
    longitude = (longitude + 180) % 360 - 180
    return np.column_stack((latitude, longitude, origin[2] + draw.uniform(-200, 9000, 41)))


@pytest.mark.parametrize("name", ORIGINS)
def test_local_metres(name):
    origin = ORIGINS[name]
    places = track_around(origin)
    expected = np.array([local(place, origin) for place in places.tolist()])
    assert np.linalg.norm(expected, axis=1).max() > 30_000
    assert np.abs(to_local(places, origin) - expected).max() < 1e-5


def test_a_file_across_the_date_line_with_altitude():
    places = np.column_stack((np.linspace(-16.4, -16.2, 30), 179.8 + np.linspace(0, 0.4, 30), np.linspace(0, 900, 30)))
    places[places[:, 1] > 180, 1] -= 360
    rows = [f"{k},{a!r},{b!r},{c!r}" for k, (a, b, c) in enumerate(places.tolist())]
    found = read("\n".join(["t,lat,lon,alt", *rows]).encode(), Reading(frame="geographic", at=(2, 3, 4)))
    expected = [local(place, places[0].tolist()) for place in places.tolist()]
    assert found.place == tuple(places[0])
    assert found.axes == ("east", "north", "up")
    assert np.abs(found.positions - expected).max() < 1e-5
    assert np.diff(found.positions[:, 0]).max() < 2_000


def test_altitude_in_feet_and_none():
    rows = "t,lat,lon,alt\n0,48,11,1000\n1,48.001,11,1000\n2,48.002,11,2000\n"
    raised = read(rows.encode(), Reading(frame="geographic", at=(2, 3, 4), units=("ft",)))
    assert raised.place == pytest.approx((48, 11, 304.8), abs=1e-12)
    assert raised.positions[2] == pytest.approx(local((48.002, 11, 609.6), (48, 11, 304.8)), abs=1e-6)
    flat = read(rows.encode(), Reading(frame="geographic", at=(2, 3)))
    assert flat.place == (48, 11, 0)
    assert flat.positions[2] == pytest.approx(local((48.002, 11, 0), (48, 11, 0))[:2], abs=1e-6)


def test_a_missing_altitude_leaves_east_and_north():
    rows = "t,lat,lon,alt\n0,48,11,0\n1,48.1,11.1,\n2,48.2,11.2,2000\n3,48.3,11.3,3000\n"
    found = read(rows.encode(), Reading(frame="geographic", at=(2, 3, 4)))
    assert np.isnan(found.positions[1, 2])
    assert found.positions[1, :2] == pytest.approx(local((48.1, 11.1, 1000), (48, 11, 0))[:2], abs=1e-6)
    assert found.counts == {"empty": 1}


def test_polar():
    rows = "t,r,b,e\n0,2,0,0\n1,2,90,0\n2,2,180,30\n3,2,-30,90\n"
    found = read(rows.encode(), Reading(frame="polar", at=(2, 3, 4), units=("km",)))
    half, root = 0.5, math.sqrt(3) / 2
    expected = [[0, 2, 0], [2, 0, 0], [0, -2 * root, 2 * half], [0, 0, 2]]
    assert found.positions == pytest.approx(1000 * np.array(expected), abs=1e-9)
    rows = f"t,r,b\n0,1,0\n1,1,{math.pi / 6!r}\n2,1,{math.pi / 2!r}\n"
    found = read(rows.encode(), Reading(frame="polar", at=(2, 3), angle="rad"))
    assert found.positions == pytest.approx(np.array([[0, 1], [half, root], [1, 0]]), abs=1e-12)
    assert found.axes == ("east", "north")
