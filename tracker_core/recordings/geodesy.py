"""Latitude, longitude and altitude to local metres: the home of the geodetic library."""

from __future__ import annotations

import numpy as np

from tracker_core.types import FloatArray


def to_local(places: FloatArray, origin: tuple[float, float, float]) -> FloatArray:
    """Metres east, north and up of a local origin, on the ellipsoid of WGS 84.

    The plane touches the ellipsoid at the origin and is not bent: a place far away lies below it. Nothing is special at
    the poles or the date line.

    Args:
        places: shape (n, 3): latitude and longitude in degrees, altitude above the ellipsoid in m.
        origin: the same of the local origin.

    Returns:
        Shape (n, 3), m; NaN where a place has one.
    """
    from pymap3d import Ellipsoid, geodetic2enu  # an extra that nothing else needs

    latitude, longitude, altitude = places.T
    local = geodetic2enu(latitude, longitude, altitude, *origin, ell=Ellipsoid.from_name("wgs84"), deg=True)
    return np.stack(local, axis=1)
