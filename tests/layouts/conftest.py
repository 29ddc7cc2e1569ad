"""What several test files share: valid settings of every kind, requests as a browser sends them, the application."""

import asyncio
import json

import httpx
import msgspec
import pytest
from hypothesis import settings
from hypothesis import strategies as st

import app
from layouts.comparing import Comparing
from layouts.controls import controls_of
from layouts.pins import SLOTS, pin_of
from layouts.questions import Question
from layouts.state import BACKGROUNDS, EXAGGERATIONS, LIMIT_FIELDS, Limits, Settings, View, inputs_of
from layouts.tuning import STUDIES, Tuning
from tracker_core import CONVENTIONS, DESIGNS, SCENARIOS, STARTS, Experiment
from tracker_core.batch import KINDS
from tracker_core.region import PLANES
from tracker_core.tuning import OBJECTIVES
from tracker_core.tuning import PARAMETERS as VARIED
from tracker_core.tuning.monte_carlo import FIGURES

# Repeatable runs: the same examples every time, and no limit on how long the compiler may take on the first.
settings.register_profile("layouts", derandomize=True, deadline=None, max_examples=100, print_blob=True)
settings.load_profile("layouts")

HOST = "gainscope.test:8050"
PARAMETER = {
    "alpha": st.floats(0.1, 0.99),
    "beta": st.floats(0.1, 2),
    "xi": st.floats(0, 0.99),
    "tracking_index": st.floats(1e-6, 1e6),
}


@st.composite
def experiments(draw):
    """A valid experiment: any scenario, design, order, convention, start and noise."""
    scenario = SCENARIOS[draw(st.sampled_from(list(SCENARIOS)))]
    noise = draw(st.sampled_from(["white", "none", *(["recorded"] if scenario.recording else [])]))
    recorded = noise == "recorded"
    design = draw(st.sampled_from(["manual", *DESIGNS]))
    order = draw(st.sampled_from(DESIGNS[design].orders if design in DESIGNS else (2, 3, 4)))
    if design == "manual":
        gains = {name: draw(st.floats(-27, 27)) for name in ("alpha", "beta", "gamma", "eta")[:order]}
    else:
        gains = {name: draw(PARAMETER[name]) for name in DESIGNS[design].parameters}
    count = draw(st.sampled_from([1, len(scenario.axes)]))
    return Experiment.from_dict(
        {
            "scenario": scenario.name,
            "samples": draw(st.integers(3, 10 if recorded else 200_000)),
            "interval": scenario.recording.interval if recorded else draw(st.floats(1e-6, 1e6)),
            "noise": noise,
            "noise_std": draw(st.lists(st.floats(0, 1e9), min_size=count, max_size=count)),
            "seed": draw(st.integers(0, 2**53 - 1)),
            "start": draw(st.sampled_from([name for name, start in STARTS.items() if start.least_order <= order])),
            "order": order,
            "convention": draw(st.sampled_from(list(CONVENTIONS))),
            "design": design,
            **gains,
        }
    )


@st.composite
def all_pins(draw):
    """Up to six pinned filters in any slots, some of them with a name of their own."""
    slots = draw(st.lists(st.sampled_from(SLOTS), unique=True, max_size=6))
    return tuple(pin_of(slot, draw(experiments())).named(draw(st.just("") | st.text(max_size=50))) for slot in slots)


@st.composite
def tunings(draw):
    """Anything that can be asked of the Tune page."""
    blind = draw(st.booleans())
    objectives = [name for name, objective in OBJECTIVES.items() if not (blind and objective.needs_truth)]
    ends = st.none() | st.floats(-1e9, 1e9)
    return Tuning(
        study=draw(st.sampled_from(list(STUDIES))),
        objective=draw(st.sampled_from(objectives)),
        against=draw(st.sampled_from(list(VARIED))),
        low=draw(ends),
        high=draw(ends),
        points=draw(st.integers(2, 1001)),
        cells=draw(st.integers(2, 200)),
        budget=draw(st.integers(2_000, 200_000)),
        runs=draw(st.integers(1, 10_000)),
        weight=draw(st.floats(0, 1)),
        without_truth=blind,
    )


@st.composite
def all_settings(draw):
    """Valid settings: an experiment, a view that fits it, and perhaps pins and limits."""
    experiment = draw(experiments())
    view = View(
        axis=draw(st.integers(0, len(SCENARIOS[experiment.scenario].axes) - 1)),
        quantity=draw(st.integers(0, experiment.order - 1)),
        exaggerate=int(draw(st.sampled_from(EXAGGERATIONS))),
        at=draw(st.none() | st.integers(0, experiment.samples - 1)),
        plane=draw(st.sampled_from(PLANES[experiment.order])),
        background=draw(st.sampled_from(BACKGROUNDS)),
        input=draw(st.sampled_from(inputs_of(experiment.order))),
        comparing=Comparing(
            draw(st.sampled_from([0, *SLOTS])), draw(st.sampled_from(KINDS)), draw(st.sampled_from(FIGURES)),
            draw(st.integers(2, 1_000_000)),
        ),
        tuning=draw(tunings()).fitted(experiment),
    )  # fmt: skip
    limits = Limits(**{name: draw(st.none() | st.floats(0, 1e9, exclude_min=True)) for name in LIMIT_FIELDS})
    return Settings(experiment, view, draw(all_pins()), limits)


# `st.from_type(Settings)` in any test file.
st.register_type_strategy(Experiment, experiments())
st.register_type_strategy(Settings, all_settings())


@pytest.fixture(scope="session")
def controls_for():
    """Controls as they stand for an experiment, given by what differs from the defaults."""

    def make(view=None, limits=None, **values):
        return controls_of(Settings(Experiment.from_dict(values), view or View(), limits=limits or Limits()))

    return make


@pytest.fixture(scope="session")
def request_for():
    """A question as it comes from the browser, where whatever was moved has been moved by a hand."""

    def make(controls, moved=None, **more):
        moved = moved or {}
        question = {
            "seq": 7,
            "controls": {**controls, **moved},
            "changed": list(moved),
            "pins": [],
            "pinning": [],
            "drawn": {},
            "want": None,
            "theme": "light",
            **more,
        }
        return msgspec.json.decode(json.dumps(question), type=Question)

    return make


@pytest.fixture(scope="session")
def dash_app():
    """The application as app.py builds it."""
    return app.build()


@pytest.fixture(scope="session")
def http(dash_app):
    """An HTTP request to the application and its answer, without a network."""

    def ask(method, path, **more):
        async def once():
            transport = httpx.ASGITransport(app=dash_app.server)
            async with httpx.AsyncClient(transport=transport, base_url=f"http://{HOST}") as client:
                return await client.request(method, path, **more)

        return asyncio.run(once())

    return ask


@pytest.fixture(scope="session")
def get(http):
    """The answer to an HTTP GET."""
    return lambda path: http("GET", path)


@pytest.fixture(scope="session")
def talk(dash_app):
    """One connection to the socket: says everything in turn, hangs up, and gives what the server sent.

    Texts go as text frames, bytes as binary ones. Without an origin given, it is a page of this very server.
    """

    def connect(*messages, origin=f"http://{HOST}", path="/explore/live"):
        frames = [
            {"type": "websocket.receive", "bytes" if isinstance(said, bytes) else "text": said} for said in messages
        ]
        incoming = iter([{"type": "websocket.connect"}, *frames, {"type": "websocket.disconnect", "code": 1000}])
        headers = {"host": HOST, "origin": origin}
        scope = {
            "type": "websocket",
            "asgi": {"version": "3.0", "spec_version": "2.4"},
            "http_version": "1.1",
            "scheme": "ws",
            "path": path,
            "raw_path": path.encode(),
            "root_path": "",
            "query_string": b"",
            "headers": [(name.encode(), value.encode()) for name, value in headers.items() if value is not None],
            "client": ("127.0.0.1", 50_000),
            "server": ("127.0.0.1", 8050),
            "subprotocols": [],
            "state": {},
        }
        sent = []

        async def receive():
            return next(incoming)

        async def send(message):
            sent.append(message)

        asyncio.run(dash_app.server(scope, receive, send))
        return sent

    return connect
