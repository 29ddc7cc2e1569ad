"""Gainscope: builds the server. `python app.py` serves it; what may be set stands in docs/server.md.

The only place that reads the environment, but for what numba reads.
"""

from __future__ import annotations

import logging
import os
import sys
import threading
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

# Read when NumPy is loaded. A second BLAS thread beside a busy neighbour makes small products many times slower.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from server import descriptors, lifecycle, logs, memory
from server.apart import Apart
from server.lifecycle import Life, Server
from server.settings import Settings
from tracker_core.checks import InputError
from tracker_core.measured import look_in
from tracker_core.tuning.cluster import Cluster
from tracker_core.tuning.executors import threads

if TYPE_CHECKING:
    from dash import Dash

    from layouts.files import Store
    from layouts.services import Services

ROOT = Path(__file__).parent
BAD_SETTING = 2
"""Exit status."""

_LOG = logging.getLogger("gainscope")
_USUAL = Settings()


def build(
    settings: Settings = _USUAL, executor: Executor | None = None, store: Store | None = None, life: Life | None = None
) -> Dash:
    """The application with all pages, routes and callbacks, behind its guard.

    Args:
        settings: what is set; it says nothing here of where to listen, and where recordings are kept `store` says.
        executor: where the parts of long studies are computed; None for this machine's threads.
        store: where recordings are kept; None for memory alone.
        life: what says whether the server is ready, and is told what to end; None for one that has only begun.
    """
    # They take most of the time of a start, in which compiled code is being loaded.
    from dash import Dash

    from layouts import document, scenes, shell, site, takeaway
    from layouts.incoming import MEGABYTE
    from layouts.uploads import WAY_IN, Uploads
    from server import guard, metrics
    from server.compression import Compression
    from server.dispatch import Dispatch, finish
    from server.files import Files, Serving

    life = life or Life()
    services = _services(settings, executor, life)
    app = Dash(
        "gainscope",
        backend=Dispatch,
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
    server = app.server
    life.attach(server)
    metrics.attach(server, settings.metrics_token)
    Uploads(store, most_bytes=int(settings.upload_mb * MEGABYTE)).attach(server)
    takeaway.attach(server, services.work, store.directory if store is not None and not store.problem else None)
    if store is not None:
        look_in(store.fetch)
    services.attach(server)
    site.register(app, services)
    app.layout = partial(shell.frame, settings.work_seconds)
    finish(app, services.work)
    files = Files(ROOT / "compressed")
    document.publish(app, files, ROOT / "assets")
    scenes.publish(files)
    server.state.files = files
    # What is added last is met first.
    server.add_middleware(Compression)
    server.add_middleware(Serving, files=files)
    guard.attach(server, settings, own_bounds={WAY_IN})
    return app


def _services(settings: Settings, executor: Executor | None, life: Life) -> Services:
    """What pages have done for them; it ends with the server."""
    from layouts.scenes import Scenes
    from layouts.services import Services
    from layouts.studies import Studies
    from server.helpers import Helpers
    from server.work import Work

    work = Work(seconds=settings.work_seconds)
    helper = sys.executable, "-m", "layouts.helper", settings.log, settings.log_level
    services = Services(
        Scenes(settings.scenes),
        Studies(work, executor, minutes=settings.study_minutes, waiting=settings.studies_waiting),
        work,
        Helpers(settings.helpers, helper, ROOT, settings.work_seconds),
    )
    life.at_stop(services.helpers.stop)
    life.at_stop(services.scenes.close)
    life.at_stop(services.studies.stop)
    return services


def prepare(life: Life) -> None:
    """Have compiled code loaded by a thread, and before that compiled by others if there is none.

    The server is ready once what every page needs is loaded; whoever needs other kernels before they are there waits.
    """

    def work() -> None:
        # Numba alone takes half a second to import.
        from tracker_core.kernels.loading import Loading

        loading = Loading(lambda: life.reach("ready"))
        life.at_stop(loading.stop)
        loading.run()
        memory.settle()

    life.reach("compiling")
    threading.Thread(target=work, name="kernels", daemon=True).start()


def cluster(settings: Settings) -> Executor | None:
    """The executor of the cluster that is set; None where none is.

    Raises:
        InputError: where no scheduler answers.
    """
    if not settings.dask_scheduler:
        return None
    try:
        return Cluster(settings.dask_scheduler)
    except InputError as error:
        name = "GAINSCOPE_DASK_SCHEDULER"
        raise InputError(name, error.rule, settings.shown()[name]) from error


def apart(settings: Settings) -> Apart:
    """Another process of this machine for the parts of studies, with a thread per processor and one less."""

    def may_start() -> bool:
        # Numba alone takes half a second to import. Before everything is compiled it would have to compile itself.
        from tracker_core.kernels.loading import held

        return not held()

    here = threads()
    workers = here._max_workers
    command = (sys.executable, "-m", "server.apart", settings.log, settings.log_level, str(workers))
    return Apart(command, workers, here, may_start, ROOT)


def data_store(settings: Settings) -> Store | None:
    """Where recordings are kept; None for memory alone."""
    from layouts.files import Store
    from layouts.incoming import MEGABYTE

    if not settings.data:
        return None
    store = Store(Path(settings.data), most_bytes=int(settings.data_mb * MEGABYTE), longest_age_days=settings.data_days)
    if store.problem:
        _LOG.warning("Recordings are kept in memory alone: %s: %s", store.directory, store.problem)
    return store


def serve(settings: Settings) -> None:
    """Build the server and serve until stopped.

    Raises:
        InputError: for a setting that only trying shows to be wrong.
    """
    # Before anything is opened or started.
    most_open = descriptors.provide(settings)
    life = Life()
    executor = cluster(settings) or apart(settings)
    life.at_stop(lambda: executor.shutdown(wait=False, cancel_futures=True))
    prepare(life)
    app = build(settings, executor, data_store(settings), life)
    more = {"settings": settings.shown(), "descriptors": most_open}
    _LOG.info("Gainscope on http://%s:%d", settings.host, settings.port, extra=more)
    Server(lifecycle.config_of(settings, app.server), life, settings.drain_seconds).run()


def main() -> int:
    """Serve as the environment says; returns the exit status: 0, or 2 for a bad setting."""
    lifecycle.leave_at_once_until_served()
    memory.share()
    try:
        settings = Settings.from_environment(os.environ)
        logs.start(settings.log, settings.log_level)
        serve(settings)
    except InputError as error:
        print(f"gainscope: {error}", file=sys.stderr)
        return BAD_SETTING
    return 0


if __name__ == "__main__":
    sys.exit(main())
