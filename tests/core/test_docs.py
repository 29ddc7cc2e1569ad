"""What the documents say is what runs."""

from __future__ import annotations

import importlib.util
import re
import shlex
from pathlib import Path

import pytest

from tracker_core.__main__ import main

ROOT = Path(__file__).parents[2]
COMMANDS = dict.fromkeys(
    line.removeprefix("python -m tracker_core ")
    for page in ("command-line", "own-data")
    for line in (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8").splitlines()
    if line.startswith("python -m tracker_core ")
)


def script(name):
    """A script of the project as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "scripts" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("name", "write"), [("reference", "reference"), ("selection", "figures")])
def test_what_a_script_has_written_is_what_it_would_write(name, write):
    module = script(name)
    assert module.TARGET.read_text(encoding="utf-8") == getattr(module, write)(), f"run scripts/{name}.py"


def test_the_documents_recomputed_are_those_of_today():
    module = script("papers")
    assert module.TARGET.read_text(encoding="utf-8") == module.page(), "run scripts/papers.py"
    assert module.README.read_text(encoding="utf-8") == module.readme(), "run scripts/papers.py"


def test_the_example_of_the_readme_runs(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    names: dict = {}
    exec(example, names)
    assert capsys.readouterr().out.endswith("stable: True\n")
    assert names["path"].shape == (1000, 2)


@pytest.mark.parametrize("command", COMMANDS)
def test_the_documented_commands_run(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "assets").symlink_to(ROOT / "assets")
    (tmp_path / "experiment.json").write_text('{"scenario": "constant-velocity"}', encoding="utf-8")
    assert main(shlex.split(command)) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("name", ["README.md", *(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md"))])
def test_every_link_of_a_document_leads_somewhere(name):
    document = ROOT / name
    targets = re.findall(r"\]\(([^)#]+)\)", document.read_text(encoding="utf-8"))
    assert [target for target in targets if not (document.parent / target).exists()] == []
