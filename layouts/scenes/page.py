"""viser's page, made to fit: hidden controls, the colours of the theme, nothing from elsewhere.

It is the same for every browser, which keeps it: the secret that a scene is found by stands behind the # of its
address, where no server sees it.
"""

from __future__ import annotations

import importlib.util
import re
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np
import zstandard

from layouts.scenes.stage import channels
from layouts.theme import THEMES, tokens
from server.files import Files
from server.policy import inline_scripts, policy

HIDE = ".mantine-Paper-root,.mantine-Notifications-root,[data-portal]{display:none!important}"
"""viser's own controls and notices, of every width of the page."""

DIGITS = b"!#$%()*+,-./0123456789:;=?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_abcdefghijklmnopqrstuvwxyz{|}~"
"""Of the numbers of base 88 that viser's page carries its parts in: five for four bytes."""

_PARTS = re.compile(r'<script data-p="(?P<packed>[^"]*)" data-ss="(?P<style>\d+)" data-cs="(?P<code>\d+)">')


@cache
def protocol() -> str:
    """The subprotocol by which viser's page and server know that they are of one version."""
    return f"viser-v{version('viser')}"


def publish(files: Files) -> None:
    """Serve the page in every theme, at /viser/<theme>/#<token>."""
    # It lies beside viser's code, which takes a second to import and is not needed here.
    found = importlib.util.find_spec("viser")
    if found is None or found.origin is None:
        raise ModuleNotFoundError("viser is not installed")
    text = Path(found.origin).with_name("client").joinpath("build", "index.html").read_text(encoding="utf-8")
    code = unpacked(text)
    for theme in THEMES:
        page = adapted(text, theme)
        headers = {"Content-Security-Policy": page_policy(page, code), "Referrer-Policy": "no-referrer"}
        files.add(f"/viser/{theme}/", page.encode(), "text/html; charset=utf-8", headers)


def adapted(text: str, theme: str) -> str:
    """viser's page with a script and a style before everything else."""
    t = tokens(theme)
    ink, paper = (", ".join(f"{part / 255:.4f}" for part in channels(t[name])) for name in ("ink-soft", "surface"))
    script = (
        # It connects to its own address, and obeys whatever else that says, such as another server to connect to.
        '{const t=/^#([0-9a-f]{32})$/.exec(location.hash);history.replaceState(null,"","../"+(t?t[1]:"nobody"))}'
        # It connects again only while it has the focus, which a frame seldom has.
        'document.hasFocus=()=>document.visibilityState==="visible";'
        'document.addEventListener("visibilitychange",()=>dispatchEvent(new Event("focus")));'
        # Whether it is connected its worker knows alone; who shows it in a frame is told.
        "window.Worker=class extends Worker{constructor(...all){super(...all);"
        'this.addEventListener("message",({data})=>{const s=data&&data.type;if(s==="connected"||s==="closed")'
        'window.frameElement?.dispatchEvent(new CustomEvent("connection",{detail:s}))})}};'
        f"window.__VISER_EMBED_CONFIG__={{darkMode:{str(theme == 'dark').lower()}}};"
        # A part that nothing here needs makes code of text at its beginning, which the policy forbids.
        'addEventListener("unhandledrejection",(e)=>{if(e.reason instanceof EvalError)e.preventDefault()});'
        # Its labels are black on white whatever the theme.
        "{const p=WebGL2RenderingContext.prototype,f=p.shaderSource;p.shaderSource=function(s,text){"
        f'return f.call(this,s,text.replace("vec4(0.0, 0.0, 0.0, a)","vec4({ink}, a)")'
        f'.replace("vec4(1.0, 1.0, 1.0, 0.85 * vAlpha)","vec4({paper}, 0.6 * vAlpha)"))}}}}'
    )
    style = f"html,body,canvas[data-engine]{{background:{t['surface']}!important}}{HIDE}"
    return text.replace("<head>", f"<head><script>{script}</script><style>{style}</style>", 1)


def unpacked(text: str) -> str:
    """The code that viser's page unpacks and runs; the policy has to name it.

    Raises:
        ValueError: for a page that is packed in another way.
    """
    parts = _PARTS.search(text)
    if parts is None:
        raise ValueError("viser's page is packed in another way than that of the version that is locked")
    style, code = int(parts["style"]), int(parts["code"])
    whole = zstandard.decompress(number(parts["packed"]), max_output_size=style + code)
    if len(whole) != style + code:
        raise ValueError("viser's page does not say how long its parts are")
    return whole[style:].decode()


def number(packed: str) -> bytes:
    """The bytes that a number of base 88 stands for: big-endian groups of five digits, the last one with fewer.

    Raises:
        ValueError: for what is no such number.
    """
    values = np.full(256, -1, dtype=np.int64)
    values[list(DIGITS)] = np.arange(len(DIGITS))
    digits = values[np.frombuffer(packed.encode("latin-1"), dtype=np.uint8)]
    if digits.size and digits.min() < 0:
        raise ValueError("viser's page carries what is no number of base 88")
    whole, rest = divmod(digits.size, 5)
    groups = digits[: 5 * whole].reshape(whole, 5) @ 88 ** np.arange(4, -1, -1)
    last = 0
    for digit in digits[5 * whole :].tolist():
        last = 88 * last + digit
    return groups.astype(">u4").tobytes() + (last.to_bytes(rest - 1, "big") if rest else b"")


def page_policy(page: str, code: str) -> str:
    """What viser's page may do: run what it is made of, and connect to this server.

    Args:
        page: the document.
        code: that it unpacks.
    """
    return policy(
        *inline_scripts(page),
        code,
        default_src="'none'",
        # It unpacks itself by compiled code.
        script_src="'wasm-unsafe-eval'",
        style_src="'unsafe-inline'",
        img_src="blob: data:",
        font_src="data:",
        connect_src="'self' blob: data:",
        worker_src="blob:",
    )
