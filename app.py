"""Gainscope: builds the server. `python app.py` serves it.

The only place that reads settings:

GAINSCOPE_HOST              address to listen at (default 127.0.0.1)
GAINSCOPE_PORT              port (default 8050)
GAINSCOPE_DASK_SCHEDULER    address of a cluster that computes long studies (default none: this machine's threads do)
GAINSCOPE_DATA              folder that recordings are kept in (default: gainscope in the user's data; empty: in memory)
GAINSCOPE_DATA_MB           size of all of them together, in megabytes (default 1000)
GAINSCOPE_DATA_DAYS         days for which one is kept that nobody uses (default 90)
GAINSCOPE_UPLOAD_MB         size of one, in megabytes (default and most 10)
"""

from __future__ import annotations

import asyncio
import os
import sys
import threading
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import uvicorn
from dash import Dash, register_page
from fastapi import FastAPI
from fastapi.responses import JSONResponse

from layouts import document, shell, takeaway
from layouts.files import Store
from layouts.incoming import MEGABYTE
from layouts.pages import compare, data, explore, papers, stability, track, tune
from layouts.scenes import Scenes
from layouts.scenes import publish as publish_scenes
from layouts.services import Services
from layouts.studies import Studies
from layouts.uploads import MOST_BYTES, Uploads
from server.compression import Compression
from server.files import Files, Serving
from tracker_core import DESIGNS, Experiment, run_experiment
from tracker_core.batch import errors_of_runs
from tracker_core.checks import Domain, InputError
from tracker_core.measured import look_in
from tracker_core.run import observe, observe_runs
from tracker_core.starts import STARTS
from tracker_core.suggestion import suggest
from tracker_core.tuning.cluster import Cluster
from tracker_core.types import ORDERS

ROOT = Path(__file__).parent
PAGES = (explore, stability, tune, compare, data, track, papers)
PORT = Domain(1, 65535, whole=True)
DATA_MEGABYTES = Domain(1, 1e9)
DATA_DAYS = Domain(1, 36_525)
UPLOAD_MEGABYTES = Domain(0, MOST_BYTES / MEGABYTE, low_open=True)

READY = threading.Event()
"""Set when the first page no longer has to wait for a compiler."""


def build(executor: Executor | None = None, store: Store | None = None, upload_bytes: int = MOST_BYTES) -> Dash:
    """The application with all pages, health routes and callbacks.

    Args:
        executor: where the parts of long studies are computed; None for this machine's threads.
        store: where recordings are kept; None for memory alone.
        upload_bytes: that a recording may have.
    """
    server = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    _add_health(server)
    Uploads(store, most_bytes=upload_bytes).attach(server)
    takeaway.attach(server)
    if store is not None:
        look_in(store.fetch)
    services = Services(Scenes(), Studies(executor))
    services.scenes.attach(server)
    app = Dash(
        "gainscope",
        server=server,  # type: ignore[arg-type]
        backend="fastapi",
        use_pages=True,
        pages_folder="",
        assets_folder=str(ROOT / "assets"),
        assets_ignore=shell.THEME_SCRIPT,
        index_string=shell.INDEX,
        include_pages_meta=False,
        # A page's parts are not there before it is opened; that they are there then is tested.
        suppress_callback_exceptions=True,
        title="Gainscope",
        update_title="",
        meta_tags=[{"name": "viewport", "content": "width=device-width, initial-scale=1"}],
    )
    for order, page in enumerate(PAGES):
        register_page(page.__name__, path=page.PATH, name=page.NAME, title=page.TITLE, order=order, layout=page.layout)
        page.register(app, services)
    app.layout = shell.frame
    _finish(app)
    files = Files(ROOT / "compressed")
    document.publish(app, files, ROOT / "assets")
    publish_scenes(files)
    server.state.files = files
    server.add_middleware(Compression)
    server.add_middleware(Serving, files=files)
    return app


def _finish(app: Dash) -> None:
    """What Dash leaves to the first request.

    A page other than the first would be answered before the pages' own callbacks are there, a socket before any.
    """
    backend: Any = app.backend
    for prepare in backend._before_request_funcs:
        waiting = prepare()
        if asyncio.iscoroutine(waiting):
            asyncio.run(waiting)


def _add_health(server: FastAPI) -> None:
    @server.get("/livez")
    async def livez() -> JSONResponse:
        return JSONResponse({"status": "alive"})

    @server.get("/readyz")
    async def readyz() -> JSONResponse:
        ready = READY.is_set()
        return JSONResponse({"status": "ready" if ready else "compiling"}, status_code=200 if ready else 503)


def warm_up() -> None:
    """Compile what every page needs, say that the server is ready, then compile what only some need.

    A gate, a suggestion or a study that comes before that waits for its kernels; nothing else does.
    """
    for order in ORDERS:
        for start in STARTS.values():
            if order >= start.least_order:
                run_experiment(Experiment.from_dict({"order": order, "xi": 0.8, "start": start.name, "samples": 20}))
    READY.set()
    gated = Experiment.from_dict({"samples": 20, "order": 2, "xi": 0.8, "gate": 4})
    suggest(observe(gated)[1])
    run_experiment(gated)
    filters = [DESIGNS["fading-memory"].gains(order, xi=0.8) for order in ORDERS]
    # Many filters in one run, many runs of one target, and runs of a target that is drawn as well.
    for scenario, runs in (("jeong-ship", 1), ("jeong-ship", 100), ("singer", 100)):
        drawn = Experiment.from_dict({"scenario": scenario, "samples": 20, "order": 2, "xi": 0.8})
        errors_of_runs(observe_runs(drawn, range(runs)), filters)


def cluster(address: str) -> Executor | None:
    """The executor of the cluster at an address; None for no address.

    Raises:
        InputError: where no scheduler answers.
    """
    if not address:
        return None
    try:
        return Cluster(address)
    except InputError as error:
        raise InputError("GAINSCOPE_DASK_SCHEDULER", error.rule, address) from error


def data_store() -> Store | None:
    """Where recordings are kept, as the settings say; None for memory alone.

    Raises:
        InputError: naming the setting, for a size or an age that is none.
    """
    megabytes = setting("GAINSCOPE_DATA_MB", "1000", DATA_MEGABYTES)
    days = setting("GAINSCOPE_DATA_DAYS", "90", DATA_DAYS)
    directory = os.environ.get("GAINSCOPE_DATA", _usual_directory())
    if not directory:
        return None
    return Store(Path(directory), most_bytes=int(megabytes * MEGABYTE), longest_age_days=days)


def _usual_directory() -> str:
    """The folder for data of the user that serves; empty where there is no such user."""
    try:
        home = os.environ.get("XDG_DATA_HOME") or str(Path.home() / ".local" / "share")
    except RuntimeError:
        return ""
    return str(Path(home) / "gainscope")


def setting(name: str, usual: str, domain: Domain) -> float:
    """A number from the environment.

    Raises:
        InputError: naming the setting.
    """
    return domain.check(name, os.environ.get(name, usual))


def main() -> int:
    """Serve until stopped."""
    host = os.environ.get("GAINSCOPE_HOST", "127.0.0.1")
    try:
        port = int(setting("GAINSCOPE_PORT", "8050", PORT))
        upload_bytes = int(setting("GAINSCOPE_UPLOAD_MB", "10", UPLOAD_MEGABYTES) * MEGABYTE)
        store = data_store()
        executor = cluster(os.environ.get("GAINSCOPE_DASK_SCHEDULER", ""))
    except InputError as error:
        print(f"gainscope: {error}", file=sys.stderr)
        return 2
    if store is not None and store.problem:
        print(f"gainscope: recordings are kept in memory alone: {store.directory}: {store.problem}", file=sys.stderr)
    app = build(executor, store, upload_bytes)
    threading.Thread(target=warm_up, name="warm-up", daemon=True).start()
    print(f"Gainscope on http://{host}:{port}", flush=True)
    uvicorn.run(app.server, host=host, port=port, log_level="warning", timeout_graceful_shutdown=5)
    return 0


if __name__ == "__main__":
    sys.exit(main())
