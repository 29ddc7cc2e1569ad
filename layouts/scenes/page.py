"""viser's page, made to fit: hidden controls, the colours of the theme, nothing from elsewhere."""

from __future__ import annotations

import gzip
import hashlib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from importlib.resources import files

from fastapi.responses import Response

from layouts.scenes.stage import channels
from layouts.theme import tokens

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' blob:; worker-src blob:; img-src blob: data:; "
    "connect-src 'self' blob: data:; style-src 'unsafe-inline'; font-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'"
)
"""The page is one file that unpacks itself, and needs nothing but its own socket."""

HIDE = ".mantine-Paper-root,.mantine-Notifications-root,[data-portal]{display:none!important}"
"""viser's own controls and notices, of every width of the page."""


@cache
def protocol() -> str:
    """The subprotocol by which viser's page and server know that they are of one version."""
    return f"viser-v{version('viser')}"


@cache
def _adapted(theme: str) -> str:
    """viser's page with a script and a style before everything else."""
    text = files("viser").joinpath("client/build/index.html").read_text(encoding="utf-8")
    t = tokens(theme)
    ink, paper = (", ".join(f"{part / 255:.4f}" for part in channels(t[name])) for name in ("ink-soft", "surface"))
    script = (
        # It connects again only while it has the focus, which a frame seldom has.
        'document.hasFocus=()=>document.visibilityState==="visible";'
        'document.addEventListener("visibilitychange",()=>dispatchEvent(new Event("focus")));'
        f"window.__VISER_EMBED_CONFIG__={{darkMode:{str(theme == 'dark').lower()}}};"
        # Its labels are black on white whatever the theme.
        "{const p=WebGL2RenderingContext.prototype,f=p.shaderSource;p.shaderSource=function(s,text){"
        f'return f.call(this,s,text.replace("vec4(0.0, 0.0, 0.0, a)","vec4({ink}, a)")'
        f'.replace("vec4(1.0, 1.0, 1.0, 0.85 * vAlpha)","vec4({paper}, 0.6 * vAlpha)"))}}}}'
    )
    style = f"html,body,canvas[data-engine]{{background:{t['surface']}!important}}{HIDE}"
    return text.replace("<head>", f"<head><script>{script}</script><style>{style}</style>", 1)


@cache
def _packed(theme: str) -> tuple[bytes, bytes, str]:
    """The page, the page compressed, and its tag."""
    data = _adapted(theme).encode()
    return data, gzip.compress(data, 6), f'"{hashlib.sha256(data).hexdigest()[:32]}"'


def client_page(theme: str, headers: Mapping[str, str]) -> Response:
    """The answer to a request for the page; its address is private, so no shared cache may keep it."""
    data, compressed, tag = _packed(theme)
    answer = {
        "Cache-Control": "private, no-cache",
        "Content-Security-Policy": POLICY,
        "ETag": tag,
        "Referrer-Policy": "no-referrer",
        "Vary": "Accept-Encoding",
        "X-Content-Type-Options": "nosniff",
    }
    if headers.get("if-none-match") == tag:
        return Response(status_code=304, headers=answer)
    if "gzip" in headers.get("accept-encoding", ""):
        data = compressed
        answer["Content-Encoding"] = "gzip"
    return Response(data, media_type="text/html", headers=answer)
