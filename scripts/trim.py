"""Takes out of an installed environment what serves nobody:  python scripts/trim.py SITE_PACKAGES

Run where the container image is built. Every line says why; licences stay. What is left out here is left out when the
release check runs the image. A line that finds nothing is out of date, and ends the build.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

MEGABYTE = 1e6

UNUSED = {
    "**/tests": "tests of packages",
    "tornado/test": "tests of packages",
    "plotly/labextension": "for notebooks",
    "plotly/package_data/widgetbundle.js": "for notebooks",
    "plotly/graph_objs/*/": "figures here are plain dicts; the classes of traces are loaded only by who names one",
    "plotly/validators": "of those classes",
    "dash/dash-renderer/build/dash_renderer.dev.js": "for Dash's own tools, which are refused in production",
    "dash/deps/*[0-9].js": "for Dash's own tools, which are refused in production",
    "dash/**/*.map": "for debuggers in browsers",
    "dask/dataframe": "needs pandas, which is not there",
    "zstandard/_cffi*": "for other interpreters than CPython",
    "setuptools": "installs and builds packages",
    "setuptools-*.dist-info": "installs and builds packages",
    "_distutils_hack": "installs and builds packages",
    "distutils-precedence.pth": "installs and builds packages",
}
"""Patterns below the folder of packages, and why nobody misses what they find."""


def size(path: Path) -> int:
    """Bytes of a file, or of all files in a folder."""
    return sum(file.stat().st_size for file in [path, *path.rglob("*")] if file.is_file() and not file.is_symlink())


def trim(packages: Path) -> dict[str, int]:
    """Remove what is unused; bytes by pattern.

    Raises:
        FileNotFoundError: naming the patterns that find nothing.
    """
    found = {pattern: sorted(packages.glob(pattern)) for pattern in UNUSED}
    if missing := [pattern for pattern, paths in found.items() if not paths]:
        raise FileNotFoundError(f"nothing in {packages} is {', '.join(missing)}: see {Path(__file__).name}")
    removed = dict.fromkeys(UNUSED, 0)
    for pattern, paths in found.items():
        # One folder of tests may have been within another.
        for path in filter(Path.exists, paths):
            removed[pattern] += size(path)
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()
    return removed


def main() -> int:
    try:
        removed = trim(Path(sys.argv[1]))
    except FileNotFoundError as error:
        print(error, file=sys.stderr)
        return 1
    for pattern, much in removed.items():
        print(f"{much / MEGABYTE:6.1f} MB  {pattern}  {UNUSED[pattern]}")
    print(f"{sum(removed.values()) / MEGABYTE:6.1f} MB  in all")
    return 0


if __name__ == "__main__":
    sys.exit(main())
