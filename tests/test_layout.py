"""The source tree keeps its shape: who may import whom, how long a module may be, and that everything is documented."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from swarmproof.systems import PACKAGES

REPOSITORY = Path(__file__).resolve().parents[1]
NAMESPACE = "swarmproof"
#: By folder, those whose modules it may import.
MAY_IMPORT = {
    "spec": {"spec"},
    "model": {"spec", "model"},
    "checks": {"spec", "model", "checks"},
    "reports": {"spec", "model", "checks", "reports"},
}
MOST_LINES = 450
#: Modules of no paper that import one all the same: of flights and experiments there is one paper only, so far.
NOT_YET = {
    "checks/campaign/decide.py",
    "checks/campaign/store.py",
    "checks/campaign/sweep.py",
    "checks/campaign/trial.py",
    "model/faults/pattern.py",
    "reports/commands/audit.py",
    "reports/commands/claims.py",
    "reports/commands/fly.py",
    "reports/commands/reproduce.py",
    "reports/options/fly.py",
    "reports/options/reproduce.py",
}


def _modules(repository: Path, folder: str) -> list[Path]:
    return sorted((repository / folder / NAMESPACE).rglob("*.py"))


def _tests(repository: Path) -> list[Path]:
    return sorted((repository / "tests").rglob("*.py"))


def _names(repository: Path, folder: str) -> set[str]:
    """Return the dotted names of this folder's modules."""
    root = repository / folder
    return {".".join(path.relative_to(root).with_suffix("").parts) for path in (root / NAMESPACE).rglob("*.py")}


def _homes(repository: Path) -> dict[str, set[str]]:
    """Return, for every module and every package of ours, the folders in which it is."""
    homes: dict[str, set[str]] = {}
    for folder in MAY_IMPORT:
        for name in _names(repository, folder):
            parts = name.split(".")
            for length in range(1, len(parts) + 1):
                homes.setdefault(".".join(parts[:length]), set()).add(folder)
    return homes


def _imports(source: str, package: tuple[str, ...]) -> Iterator[str]:
    """Yield the dotted name of everything that a module of `package` imports, wherever in it."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parents = package[: len(package) - node.level + 1] if node.level else ()
            base = ".".join([*parents, *([node.module] if node.module else [])])
            yield from (f"{base}.{alias.name}" for alias in node.names)


def _imports_of(repository: Path, folder: str, path: Path) -> Iterator[str]:
    return _imports(path.read_text(encoding="utf-8"), path.relative_to(repository / folder).parent.parts)


def wrong_imports(repository: Path) -> list[str]:
    """Return the imports between the folders that are not allowed, as ``module imports what (which is in folder)``."""
    homes = _homes(repository)
    wrong = []
    for folder, allowed in MAY_IMPORT.items():
        for path in _modules(repository, folder):
            for imported in _imports_of(repository, folder, path):
                if imported.split(".")[0] != NAMESPACE:
                    continue
                parent = imported.rpartition(".")[0]
                where = homes.get(imported) or (homes.get(parent) if parent != NAMESPACE else None) or {"nowhere"}
                if not where & allowed:
                    wrong.append(f"{path.relative_to(repository)} imports {imported} ({', '.join(sorted(where))})")
    return wrong


def papers(repository: Path) -> set[str]:
    """Return the packages that are systems under test: those with a module `system` in `checks`."""
    return {path.parent.name for path in (repository / "checks" / NAMESPACE).glob("*/system.py")}


def paper_imports(repository: Path) -> dict[str, list[str]]:
    """Return, by module outside of a paper's package, what it imports of a paper; a paper may import only itself."""
    found: dict[str, list[str]] = {}
    for folder in MAY_IMPORT:
        for path in _modules(repository, folder):
            relative = path.relative_to(repository / folder / NAMESPACE)
            for imported in _imports_of(repository, folder, path):
                parts = imported.split(".")
                paper = parts[1] if len(parts) > 1 and parts[0] == NAMESPACE else ""
                if paper in papers(repository) and paper != relative.parts[0]:
                    found.setdefault(f"{folder}/{relative.as_posix()}", []).append(imported)
    return found


def foreign_imports(repository: Path, folder: str) -> list[str]:
    """Return the imports of a folder's modules that are neither ours nor of the standard library."""
    return [
        f"{path.relative_to(repository)} imports {imported}"
        for path in _modules(repository, folder)
        for imported in _imports_of(repository, folder, path)
        if imported.split(".")[0] not in {NAMESPACE, *sys.stdlib_module_names}
    ]


_Documentable = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def _undocumented(path: Path, nodes: Iterator[_Documentable]) -> list[str]:
    return [f"{path}:{node.lineno} {node.name}" for node in nodes if not ast.get_docstring(node)]


def undocumented_names(path: Path) -> list[str]:
    """Return the module-level public functions and classes of a module that have no docstring."""
    body = ast.parse(path.read_text(encoding="utf-8")).body
    named = (node for node in body if isinstance(node, _Documentable))
    return _undocumented(path, (node for node in named if not node.name.startswith("_")))


def undocumented_tests(path: Path) -> list[str]:
    """Return the test functions of a module, methods included, that have no docstring."""
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    functions = (node for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))
    return _undocumented(path, (node for node in functions if node.name.startswith("test")))


@pytest.fixture
def small_tree(tmp_path: Path) -> Path:
    """Return a tree like ours in which every import is allowed."""
    sources = {
        "spec/swarmproof/claims/claim.py": "import dataclasses\n",
        "spec/swarmproof/paper/claims.py": "from swarmproof.claims.claim import Claim\n",
        "model/swarmproof/paper/protocol.py": "from swarmproof.paper.claims import Claim\n",
        "checks/swarmproof/paper/system.py": "from swarmproof.paper import protocol\nimport swarmproof.explore\n",
        "checks/swarmproof/explore/search.py": "from .steps import follow\n",
        "checks/swarmproof/explore/steps.py": "def f():\n    from swarmproof.claims import claim\n",
        "reports/swarmproof/cli.py": "import numpy\nimport swarmproof.explore\n",
    }
    for name, source in sources.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(source, encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize("folder", MAY_IMPORT)
def test_the_namespace_has_no_init(folder: str) -> None:
    """No folder has an `__init__.py` in or under its `swarmproof`, since it would hide the other three folders."""
    assert not list((REPOSITORY / folder).rglob("__init__.py"))


def test_every_folder_has_modules() -> None:
    """The checks of this file look at something in each of the four folders."""
    assert all(_modules(REPOSITORY, folder) for folder in MAY_IMPORT)
    assert _tests(REPOSITORY)


def test_imports_go_one_way() -> None:
    """`spec` imports nothing of ours but itself, `model` also `spec`, `checks` also `model`; `reports` all of them."""
    assert wrong_imports(REPOSITORY) == []


def test_engines_import_no_paper() -> None:
    """Whatever is outside of a paper's package imports no paper, but for the modules of the list above."""
    assert papers(REPOSITORY) == set(PACKAGES.values())
    assert set(paper_imports(REPOSITORY)) == NOT_YET


def test_no_module_is_in_two_folders() -> None:
    """Each module is in one folder only, and no package has its name, so that a reader knows where it is."""
    names = [name for folder in MAY_IMPORT for name in _names(REPOSITORY, folder)]
    assert sorted(names) == sorted(set(names))
    packages = {name.rpartition(".")[0] for name in names}
    assert packages & set(names) == set()


def test_the_specification_needs_only_the_standard_library() -> None:
    """`spec` imports no third-party package."""
    assert foreign_imports(REPOSITORY, "spec") == []


def test_no_module_is_too_long() -> None:
    """No module of the four folders has more than 450 lines."""
    paths = [path for folder in MAY_IMPORT for path in _modules(REPOSITORY, folder)]
    lengths = {str(path.relative_to(REPOSITORY)): len(path.read_text(encoding="utf-8").splitlines()) for path in paths}
    assert {path: length for path, length in lengths.items() if length > MOST_LINES} == {}


def test_everything_public_is_documented() -> None:
    """Every module-level public function and class of the four folders has a docstring."""
    paths = [path for folder in MAY_IMPORT for path in _modules(REPOSITORY, folder)]
    assert [name for path in paths for name in undocumented_names(path)] == []


def test_every_test_says_what_must_be_true() -> None:
    """Every test function has a docstring."""
    assert [name for path in _tests(REPOSITORY) for name in undocumented_tests(path)] == []


def test_allowed_imports_are_allowed(small_tree: Path) -> None:
    """The checker accepts a tree in which all imports go the right way."""
    assert wrong_imports(small_tree) == []
    assert foreign_imports(small_tree, "spec") == []


@pytest.mark.parametrize(
    ("planted_in", "source"),
    [
        ("spec/swarmproof/claims/planted.py", "from swarmproof.paper.protocol import Swarm\n"),
        ("spec/swarmproof/claims/planted.py", "from swarmproof.paper import protocol\n"),
        ("spec/swarmproof/paper/planted.py", "from . import protocol\n"),
        ("spec/swarmproof/claims/planted.py", "from .. import explore\n"),
        ("model/swarmproof/paper/planted.py", "import swarmproof.explore.search\n"),
        ("model/swarmproof/paper/planted.py", "def f():\n    import swarmproof.explore.search as s\n"),
        ("checks/swarmproof/explore/planted.py", "from swarmproof.cli import main\n"),
        ("checks/swarmproof/explore/planted.py", "from swarmproof.nowhere import nothing\n"),
        ("spec/swarmproof/claims/planted.py", "if False:\n    from swarmproof.explore import search\n"),
    ],
)
def test_a_wrong_import_is_noticed(small_tree: Path, planted_in: str, source: str) -> None:
    """The checker reports an import that goes the wrong way, or nowhere, however it is written."""
    (small_tree / planted_in).write_text(source, encoding="utf-8")
    (reported,) = wrong_imports(small_tree)
    assert Path(planted_in).name in reported


@pytest.mark.parametrize(
    "source",
    [
        "from swarmproof.paper.claims import Claim\n",
        "def f():\n    from swarmproof.paper import protocol\n",
        "from swarmproof import paper\n",
        "from ..paper import system\n",
    ],
    ids=["of a module", "in a function", "the package", "relative"],
)
def test_a_paper_in_an_engine_is_noticed(small_tree: Path, source: str) -> None:
    """The checker reports an engine that imports a paper; the paper itself may."""
    assert paper_imports(small_tree) == {}
    (small_tree / "checks/swarmproof/explore/planted.py").write_text(source, encoding="utf-8")
    assert list(paper_imports(small_tree)) == ["checks/explore/planted.py"]


def test_a_third_party_import_is_noticed(small_tree: Path) -> None:
    """The checker reports a third-party package in `spec`."""
    (small_tree / "spec/swarmproof/claims/planted.py").write_text("from numpy import array\n", encoding="utf-8")
    assert len(foreign_imports(small_tree, "spec")) == 1


def test_missing_docstrings_are_noticed(tmp_path: Path) -> None:
    """The checker reports public functions, classes and tests without docstrings, and nothing else."""
    path = tmp_path / "test_planted.py"
    path.write_text(
        "def _private(): pass\n"
        "def public(): pass\n"
        "class Public:\n    def test_method(self): pass\n"
        "def documented():\n    '''So it is.'''\n",
        encoding="utf-8",
    )
    assert [found.split()[-1] for found in undocumented_names(path)] == ["public", "Public"]
    assert [found.split()[-1] for found in undocumented_tests(path)] == ["test_method"]
