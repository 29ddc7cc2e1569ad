"""The document that every page begins with, and the files that it needs: made when the server starts, once.

Dash makes its document anew for every request, says in it what runs here, and serves each script uncompressed. Here
it is asked for it once: what no page needs is left out, and every address in it is one that is named by its content.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dash import Dash, page_registry
from dash.backends._fastapi import reset_current_request, set_current_request
from dash.fingerprint import check_fingerprint
from fastapi import FastAPI, Request
from fastapi.responses import Response

from server.files import Files
from server.policy import inline_scripts, policy

SUITES, ASSETS = "_dash-component-suites/", "assets/"
PLOTLY = f"{SUITES}plotly/package_data/plotly.min.js"
HTML = "text/html; charset=utf-8"

UNUSED = ("dash/dash_table/", "dash/dcc/async-mathjax")
"""Of Dash's scripts: its tables, and what sets formulas."""

TOLD = (
    "dash_version", "dash_version_url", "ddk_version", "disable_version_check", "plotly_cloud_installed",
    "plotly_version", "python_version",
)  # fmt: skip
"""Settings of Dash that say what runs here; no page asks for them."""

_ADDRESS = re.compile(rf'(?P<name>src|href)="/?(?P<path>(?:{SUITES}|{ASSETS})[^"?]+)[^"]*"')
_SCRIPT = re.compile(rf'<script src="/{SUITES}(?P<path>[^"]+)"></script>\n')
_CONFIG = re.compile(r'(?<=<script id="_dash-config" type="application/json">).*?(?=</script>)', re.DOTALL)


def publish(app: Dash, files: Files, assets: Path) -> None:
    """Serve the document of every page, its scripts and styles, and what Dash asks for at its beginning.

    Args:
        app: with all its pages and callbacks.
        files: where they are served.
        assets: folder of the pages' own scripts and styles.
    """
    own = {path.relative_to(assets).as_posix(): path for path in assets.rglob("[!.]*") if path.is_file()}
    folder = files.publish("assets", own)
    addresses = {ASSETS + name: folder + name for name in own}
    for name, path in own.items():
        # The pages name some without knowing what is in them.
        files.add(f"/{ASSETS}{name}", path)
    for package, contents in _suites(app).items():
        folder = files.publish(package, contents)
        addresses |= {f"{SUITES}{package}/{name}": folder + name for name in contents}
    text = document(app, addresses)
    headers = {"Content-Security-Policy": document_policy(text)}
    pages = {page["path"] for page in page_registry.values()}
    for page in pages:
        files.add(page, text.encode(), HTML, headers)
    for name, answer in (("layout", app.serve_layout()), ("dependencies", app.dependencies())):
        files.add(f"/_dash-{name}", answer.body, "application/json")
    files.close(f"/{SUITES}", f"/{ASSETS}", "/_favicon.ico", "/_reload-hash")
    server: FastAPI = app.server

    @server.get("/{path:path}")
    async def other(request: Request, path: str) -> Response:
        page = f"/{path.strip('/')}"
        return await files.response(files.at("/"), request.headers, 200 if page in pages else 404)


def document(app: Dash, addresses: Mapping[str, str]) -> str:
    """The document, with the addresses under which its files are served in place of Dash's own.

    Args:
        app: whose document it is.
        addresses: by Dash's, without the first slash, fingerprints and queries.
    """
    # Dash wants to know the request, and does not look at it.
    token = set_current_request(Request({"type": "http", "headers": []}))
    try:
        text = app.index()
    finally:
        reset_current_request(token)
    text = _SCRIPT.sub(lambda script: "" if script["path"].startswith(UNUSED) else script[0], text)
    text = _ADDRESS.sub(lambda found: f'{found["name"]}="{addresses[_plain(found["path"])]}"', text)
    return _CONFIG.sub(lambda config: _settings(json.loads(config[0]), addresses), text)


def document_policy(text: str) -> str:
    """What the browser may do on behalf of the document; who may show it in a frame is not in it."""
    return policy(
        *inline_scripts(text),
        # Dash's scripts put their styles into the document.
        style_src="'self' 'unsafe-inline'",
        # plotly makes the pictures of its figures from such.
        img_src="'self' data: blob:",
    )


def _suites(app: Dash) -> dict[str, dict[str, Path]]:
    """What Dash would serve, by package and name."""
    suites = {}
    for package, names in app.registered_paths.items():
        root = Path(str(sys.modules[package].__file__)).parent
        suites[package] = {
            name: root / name
            for name in names
            if not name.endswith(".map") and not f"{package}/{name}".startswith(UNUSED)
        }
    return suites


def _plain(path: str) -> str:
    """Dash's address without its fingerprint."""
    return str(check_fingerprint(path)[0])


def _settings(config: dict[str, Any], addresses: Mapping[str, str]) -> str:
    """Dash's settings as the browser needs them."""
    kept = {name: value for name, value in config.items() if name not in TOLD}
    # The only thing that depends on it is where plotly is asked for.
    kept |= {"serve_locally": False, "plotlyjs_url": addresses[PLOTLY]}
    return json.dumps(kept, separators=(",", ":")).replace("<", "\\u003c")
