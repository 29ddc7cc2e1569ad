"""Compresses all files that the pages are made of, as small as it goes: a server that finds them there need not.

Run from the root of the checkout, as the image is built: `python -m scripts.compress`.
"""

from __future__ import annotations

import app
from server.files import Files


def main() -> None:
    files: Files = app.build().server.state.files
    assert files.kept is not None
    size = files.prepare(files.kept)
    print(f"{files.kept}: {size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
