"""The package as a whole: what importing it costs, what it offers, and that all of it is documented."""

import ast
import importlib
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

import tracker_core
from tracker_core import CONVENTIONS, DESIGNS, METRICS, SCENARIOS, STARTS
from tracker_core.manoeuvre import MANOEUVRES
from tracker_core.noise import NOISES
from tracker_core.papers import papers

ROOT = Path(__file__).parents[2]
MODULES = ["tracker_core", *(m.name for m in pkgutil.walk_packages(tracker_core.__path__, "tracker_core."))]
WEB = ["dash", "plotly", "fastapi", "starlette", "flask", "uvicorn", "viser"]


def loaded_after(statement):
    """Names of the modules that a fresh interpreter has loaded after a statement."""
    code = f"{statement}\nimport sys\nprint(' '.join(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, encoding="utf-8", check=True)
    return set(done.stdout.split())


def test_importing_the_package_loads_neither_web_nor_compiler():
    """It works in a notebook with numpy alone, and starts at once."""
    loaded = loaded_after("import tracker_core")
    assert "tracker_core.filters" in loaded
    assert loaded.isdisjoint([*WEB, "numba", "llvmlite", "scipy", "layouts", "app"])


def test_running_it_loads_the_compiler_but_no_web_package():
    every_module = "\n".join(f"import {name}" for name in MODULES)
    run = "from tracker_core import *\nrun_experiment(Experiment.from_dict({'samples': 3}))"
    loaded = loaded_after(f"{every_module}\n{run}")
    assert "numba" in loaded
    assert loaded.isdisjoint([*WEB, "layouts", "app"])


def test_the_public_names_are_there_and_complete():
    assert all(hasattr(tracker_core, name) for name in tracker_core.__all__)
    offered = {
        name
        for name, value in vars(tracker_core).items()
        if not name.startswith("_") and not isinstance(value, type(tracker_core))
    }
    assert offered == set(tracker_core.__all__)


# Documentation -----------------------------------------------------------------------------------------------------


def public_definitions(module):
    """Every public function, class and method of a module's source, as (dotted name, node)."""

    def walk(node, prefix):
        for child in node.body:
            if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and not child.name.startswith(
                "_"
            ):
                name = f"{prefix}.{child.name}"
                yield name, child
                if isinstance(child, ast.ClassDef):
                    yield from walk(child, name)

    source = Path(importlib.import_module(module).__file__).read_text(encoding="utf-8")
    return list(walk(ast.parse(source), module))


DEFINITIONS = [item for module in MODULES for item in public_definitions(module)]


def test_the_search_for_definitions_finds_them():
    names = {name for name, _ in DEFINITIONS}
    assert {
        "tracker_core.filters.run_filter",
        "tracker_core.kernels.recursions.track4",
        "tracker_core.experiment.Experiment.from_dict",
        "tracker_core.design.base.Design.orders",
    } <= names


@pytest.mark.parametrize("module", MODULES)
def test_module_has_a_docstring(module):
    assert importlib.import_module(module).__doc__


@pytest.mark.parametrize("node", [pytest.param(node, id=name) for name, node in DEFINITIONS])
def test_public_definition_has_a_docstring(node):
    assert ast.get_docstring(node)


@pytest.mark.parametrize(
    ("name", "node"),
    [pytest.param(name, node, id=name) for name, node in DEFINITIONS if isinstance(node, ast.ClassDef)],
)
def test_public_class_describes_its_fields(name, node):
    """Every annotated field, unless the docstring says which registry or table the names come from."""
    fields = [item.target.id for item in node.body if isinstance(item, ast.AnnAssign)]
    text = ast.get_docstring(node)
    if name in {"tracker_core.metrics.Metrics", "tracker_core.run.Result"}:
        return
    assert [field for field in fields if field not in text] == []


REGISTRIES: dict[str, dict] = {
    "design": DESIGNS,
    "scenario": SCENARIOS,
    "convention": CONVENTIONS,
    "start": STARTS,
    "noise": NOISES,
    "manoeuvre": MANOEUVRES,
    "metric": METRICS,
    "paper": papers(),
}
# Where a registry says what its entries rest on.
SOURCE = {
    "design": "source",
    "scenario": "source",
    "convention": "used_by",
    "start": "sentence",
    "metric": "formula",
    "paper": "citation",
}
ENTRIES = [(kind, name) for kind, registry in REGISTRIES.items() for name in registry]


@pytest.mark.parametrize(("kind", "name"), ENTRIES)
def test_registry_entry_has_title_and_source(kind, name):
    entry = REGISTRIES[kind][name]
    assert entry.title.strip()
    if kind in SOURCE:
        assert getattr(entry, SOURCE[kind]).strip()


@pytest.mark.parametrize("kind", REGISTRIES)
def test_registry_titles_are_distinct(kind):
    titles = [entry.title for entry in REGISTRIES[kind].values()]
    assert len(set(titles)) == len(titles)
