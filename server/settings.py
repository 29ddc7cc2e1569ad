"""What whoever runs the server may set."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Settings:
    """Everything that may be set, with what is used where nothing is.

    Attributes:
        host: address to listen at.
        port: to listen at.
        mode: "production", or "development", in which Dash's own tools may be switched on.
        proxies: addresses and networks of proxies, whose word is taken for who the client is; comma between them.
        frames: sources that may show pages in a frame, as in `frame-ancestors` of a content security policy.
        dask_scheduler: address of a cluster that computes long studies; empty for this machine's threads.
        data: folder that recordings are kept in; empty for memory alone.
        data_mb: size of all recordings together, megabytes.
        data_days: days for which a recording is kept that nobody uses.
        upload_mb: size of one recording, megabytes.
        body_kb: size of any other request's body, kilobytes.
        requests_per_second: of one client, for long.
        requests_at_once: of one client, in a burst.
        sockets: open at a time.
        sockets_per_client: of them of one client.
        scenes: in three dimensions, open at a time.
        work_seconds: that one answer may take.
        study_minutes: that one study may take.
        studies_waiting: studies that may wait for their turn.
        drain_seconds: for which requests are still taken after the server was told to stop.
        metrics_token: that `/metrics` asks for; without one it answers this machine alone.
        log: "json" or "text".
        log_level: the least that is logged: "debug", "info", "warning" or "error".
    """

    host: str = "127.0.0.1"
    port: int = 8050
    mode: str = "production"
    proxies: str = ""
    frames: str = "'self'"
    dask_scheduler: str = ""
    data: str = ""
    data_mb: float = 1000.0
    data_days: float = 90.0
    upload_mb: float = 10.0
    body_kb: float = 256.0
    requests_per_second: float = 100.0
    requests_at_once: int = 2000
    sockets: int = 2000
    sockets_per_client: int = 500
    scenes: int = 150
    work_seconds: float = 30.0
    study_minutes: float = 60.0
    studies_waiting: int = 100
    drain_seconds: float = 1.0
    metrics_token: str = ""
    log: str = "json"
    log_level: str = "info"
