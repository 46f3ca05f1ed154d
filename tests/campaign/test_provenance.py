"""What identifies the code that measures: it changes with every rule that a flight depends on, and nothing else."""

from __future__ import annotations

import ast
import json
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from swarmproof.campaign import provenance as module
from swarmproof.campaign import store, sweep
from swarmproof.campaign import trial as cell
from swarmproof.campaign.provenance import made_by, modules
from swarmproof.dmpc_swarm.claims import experiments, flight, predicates
from swarmproof.dmpc_swarm.experiments import measure
from swarmproof.dmpc_swarm.flight import judge
from swarmproof.dmpc_swarm.planner import detour, outlook, qp
from swarmproof.dmpc_swarm.protocol import algorithm2
from swarmproof.scenario import choices, formations, scenario

REPOSITORY = Path(__file__).resolve().parents[2]
#: A flight, what it loads, and what it reads; told as JSON.
WATCHED = """
import json, sys
from swarmproof.campaign.trial import Cell
from swarmproof.dmpc_swarm.experiments.measure import measure
read = []
sys.addaudithook(lambda event, arguments: read.append(str(arguments[0])) if event == "open" else None)
for scenario in ("crossing", "circle", "random", "formations"):
    changes = ("hold=1",) if scenario == "formations" else ()
    measure(Cell(scenario, 2, "HT", "iid:0.1", "guarded", 0, 2, changes))
loaded = {name: getattr(module, "__file__", None) for name, module in list(sys.modules.items())}
print(json.dumps([loaded, read]))
"""


#: What a module does, and what it imports, by its place and its text: only what is edited is read anew.
once: dict[tuple[object, Path, str], Any] = {}


def remembered(of: Callable[[Path], Any]) -> Callable[[Path], Any]:
    """Return the function with a memory for files whose text is the same."""

    def answer(path: Path) -> Any:
        key = (of, path, path.read_text(encoding="utf-8"))
        if key not in once:
            found = of(path)
            once[key] = found if isinstance(found, str) else tuple(found)
        return once[key]

    return answer


@pytest.fixture(autouse=True)
def _anew(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Compute the digest when it is asked for, not once for all tests."""
    for name in ("_rules", "_imported"):
        monkeypatch.setattr(module, name, remembered(getattr(module, name)))
    made_by.cache_clear()
    yield
    made_by.cache_clear()


def digest() -> str:
    """Return the digest of our code as it is read now."""
    made_by.cache_clear()
    return made_by()["swarmproof"]


#: That of the code as it is, computed once.
ours = cache(digest)


@pytest.fixture
def edit(monkeypatch: pytest.MonkeyPatch) -> Callable[[Path, str, str], str]:
    """Return what gives the digest if a file had other text: the first occurrence of some text is replaced."""
    real_text, real_bytes = Path.read_text, Path.read_bytes

    def edited(path: Path, old: str, new: str) -> str:
        before = real_text(path, encoding="utf-8")
        assert old in before
        after = before.replace(old, new, 1)
        assert after != before

        def read_text(self: Path, *arguments: Any, **options: Any) -> str:
            return after if self == path else real_text(self, *arguments, **options)

        def read_bytes(self: Path) -> bytes:
            return after.encode() if self == path else real_bytes(self)

        with monkeypatch.context() as patch:
            patch.setattr(Path, "read_text", read_text)
            patch.setattr(Path, "read_bytes", read_bytes)
            return digest()

    return edited


def path_of(of: Any) -> Path:
    """Return the file of a module."""
    return Path(of.__file__)


#: A rule, a number or a word in modules that are imported near and far: file, old text, new text.
RULES = {
    "a number of the planner": (path_of(outlook), "ARRIVED = 0.05", "ARRIVED = 0.06"),
    "the problem": (path_of(qp), "import numpy as np", "import numpy as np\n\n_MORE = 1"),
    "an algorithm": (path_of(algorithm2), "deprecated[i] = False", "deprecated[i] = True"),
    "the judge": (path_of(judge), "PATIENCE = 50.0", "PATIENCE = 51.0"),
    "a predicate": (path_of(predicates), "return [", "return 2 * ["),
    "a choice": (path_of(choices), 'offer: str = "lowest"', 'offer: str = "highest"'),
    "a formation": (path_of(formations), "import", "import math as _more\nimport"),
    "what is measured": (path_of(measure), "+ 1 if", "+ 2 if"),
    "what a cell is": (path_of(cell), "self.trigger, self.preset", "self.preset, self.trigger"),
    "a shipped scenario": (path_of(scenario).with_name("circle.toml"), "1.45", "1.44"),
    "a module more": (path_of(qp), "import numpy as np", "import numpy as np\nfrom swarmproof.campaign import matrix"),
}
#: What says nothing of what is done.
WORDS = {
    "a comment": (path_of(outlook), "ARRIVED = 0.05", "ARRIVED = 0.05  # enough"),
    "a comment in its own line": (path_of(qp), "import numpy as np", "# plans\nimport numpy as np"),
    "a module's docstring": (path_of(detour), '"""', '"""Once more: '),
    "a function's docstring": (path_of(outlook), '"""Return', '"""Give back'),
    "a class's docstring": (path_of(choices), '"""What the planner does where the paper is silent; the', '"""Here the'),
    "a method's docstring": (path_of(choices), '"""Raise', '"""Throw'),
    "an empty line": (path_of(qp), "import numpy as np", "\nimport numpy as np"),
    "a claim about experiments": (path_of(experiments), "SIMILAR = 0.2", "SIMILAR = 0.3"),
    "where results are kept": (path_of(store), "swarmproof.cell/1", "swarmproof.cell/2"),
    "who flies": (path_of(sweep), "time.process_time()", "time.monotonic()"),
}


@pytest.mark.parametrize("name", RULES)
def test_a_rule_changes_it(name: str, edit: Callable[[Path, str, str], str]) -> None:
    """Whatever flights, or their numbers, depend on changes the digest."""
    assert edit(*RULES[name]) != ours()


@pytest.mark.parametrize("name", WORDS)
def test_words_do_not_change_it(name: str, edit: Callable[[Path, str, str], str]) -> None:
    """Comments, docstrings, empty lines, and modules that no flight needs leave the digest as it is."""
    assert edit(*WORDS[name]) == ours()


def test_results_of_code_that_was_only_moved_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """A result counts if this code made it, or earlier code with the same numbers; with the same libraries only."""
    earlier = {**made_by(), "swarmproof": "0123456789abcdef"}
    assert module.counts(made_by())
    assert not module.counts(earlier)
    monkeypatch.setattr(module, "SAME_NUMBERS", {ours(): ("0123456789abcdef",)})
    assert module.counts(earlier)
    assert not module.counts({**earlier, "numpy": "1.0"})
    assert not module.counts({**earlier, "more": "1"})
    monkeypatch.setattr(module, "SAME_NUMBERS", {"another": ("0123456789abcdef",)})
    assert not module.counts(earlier)


def test_where_ours_is_found_does_not_count(tmp_path: Path) -> None:
    """A module is the same if what it imports of ours has moved; not if it imports something else by that name."""
    path = tmp_path / "one.py"

    def rules(text: str) -> str:
        path.write_text(f"{text}\nlook()\n", encoding="utf-8")
        return module._rules(path)

    here = rules("import numpy\nfrom swarmproof.dmpc_swarm.planner.outlook import look")
    assert rules("import numpy\nfrom swarmproof.elsewhere.far import look") == here
    assert rules("import numpy\nfrom swarmproof.dmpc_swarm.planner.outlook import Outlook as look") != here
    assert rules("import numpy as np\nfrom swarmproof.dmpc_swarm.planner.outlook import look") != here
    assert rules("import numpy\nfrom scipy import look") != here


def test_text_that_is_no_docstring_counts(edit: Callable[[Path, str, str], str]) -> None:
    """A string that is not the first statement may be a rule."""
    path = path_of(choices)
    assert edit(path, '("lowest", "highest")', '("lowest", "topmost")') != ours()


def test_it_does_not_change_by_itself() -> None:
    """Twice the same, and 16 hexadecimal digits."""
    assert digest() == ours()
    assert len(ours()) == 16
    assert set(ours()) <= set("0123456789abcdef")


def test_versions_are_those_of_the_libraries(monkeypatch: pytest.MonkeyPatch) -> None:
    """The interpreter and the libraries that compute are named with their versions; another version is another code."""
    found = made_by()
    assert set(found) == {"swarmproof", "python", "numpy", "piqp", "scipy"}
    assert found["python"] == platform.python_version()
    assert all(found[name] == version(name) for name in ("numpy", "piqp", "scipy"))
    monkeypatch.setattr(module, "version", lambda name: "0.0" if name == "piqp" else version(name))
    made_by.cache_clear()
    assert made_by() == {**found, "piqp": "0.0"}


def test_modules_are_those_of_a_flight() -> None:
    """The planner, the judge, the protocol, the scenarios and their choices are among them, where they are."""
    found = modules()
    for of in (judge, qp, algorithm2, scenario, choices, measure, cell, flight, predicates, outlook, detour):
        assert found[of.__name__] == path_of(of)
    assert not any(name.startswith(("swarmproof.pages", "swarmproof.commands", "swarmproof.margin")) for name in found)
    assert experiments.__name__ not in found


def test_nothing_else_is_loaded_or_read_by_flights() -> None:
    """An interpreter that has flown has no other module of ours, no other library, and read no other file of ours."""
    done = subprocess.run(
        [sys.executable, "-c", WATCHED],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )
    loaded, read = json.loads(done.stdout)
    of_us = {name for name, file in loaded.items() if name.startswith("swarmproof") and file is not None}
    assert of_us
    assert of_us <= set(modules())
    installed = {name.split(".")[0] for name, file in loaded.items() if file and "site-packages" in Path(file).parts}
    # what an editable installation and virtual environments load by themselves computes nothing
    assert {name for name in installed if not name.startswith("_")} <= set(made_by())
    assert {"numpy", "piqp"} <= installed
    here = {path for path in map(Path, read) if path.is_relative_to(REPOSITORY) and "site-packages" not in path.parts}
    data = {path for path in here if path.suffix not in (".py", ".pyc") and "__pycache__" not in path.parts}
    assert {path.name for path in data} == {"circle.toml", "crossing.toml", "formations.toml", "random.toml"}
    assert {path.parent for path in data} == {path_of(scenario).parent}


@pytest.mark.parametrize("folder", ["spec", "model", "checks"])
def test_imports_are_of_the_form_that_is_followed(folder: str) -> None:
    """The digest follows `from swarmproof.x import y`: there is no `import swarmproof.x`, and no import with dots."""
    paths = sorted((REPOSITORY / folder / "swarmproof").rglob("*.py"))
    assert paths
    for path in paths:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                assert not any(alias.name.split(".")[0] == "swarmproof" for alias in node.names), path
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, path
                assert node.module != "swarmproof", path


def test_no_module_of_a_flight_imports_by_a_string() -> None:
    """What is imported by a name that is computed would not be followed."""
    for name, path in modules().items():
        text = path.read_text(encoding="utf-8")
        assert "import_module" not in text, name
        assert "__import__" not in text, name


def test_it_does_not_matter_where_the_code_is(tmp_path: Path) -> None:
    """A copy in another place is the same code, until a rule in it is changed."""
    for folder in ("spec", "model", "checks"):
        shutil.copytree(REPOSITORY / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    code = (
        "from swarmproof.campaign import provenance as module\n"
        "print(module.__file__, module.made_by()['swarmproof'])\n"
        "path = module.modules()['swarmproof.dmpc_swarm.planner.outlook']\n"
        "path.write_text(path.read_text().replace('ARRIVED = 0.05', 'ARRIVED = 0.06'))\n"
        "module.made_by.cache_clear()\n"
        "print(path, module.made_by()['swarmproof'])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(str(tmp_path / one) for one in ("spec", "model", "checks"))},
    )
    (here, same), (there, other) = (line.split() for line in done.stdout.splitlines())
    assert Path(here).is_relative_to(tmp_path)
    assert Path(there).is_relative_to(tmp_path)
    assert same == ours() != other
