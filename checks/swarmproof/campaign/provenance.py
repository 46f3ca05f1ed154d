"""What numbers depend on beside their cell: our code and the libraries' versions. Others' results are not mixed in."""

from __future__ import annotations

import ast
import hashlib
import platform
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

_ROOT = "swarmproof.dmpc_swarm.experiments.measure"
#: By digest of our code, digests of earlier code with the same numbers to the bit (tests/golden): it was only moved.
SAME_NUMBERS: dict[str, tuple[str, ...]] = {"9d1cd86e8c1f3dd6": ("b4cc710be4fe88c6",)}
_LIBRARIES = ("numpy", "piqp", "scipy")


@cache
def made_by() -> dict[str, str]:
    """Return what identifies the code that flies and measures a cell: a digest of ours, and versions of others'.

    The digest is over all modules that :mod:`swarmproof.dmpc_swarm.experiments.measure` needs, without comments and
    docstrings, and over the scenarios that ship. What our modules are called, and where they are, does not count.
    """
    digest = hashlib.sha256()
    paths = modules().values()
    for rules in sorted(_rules(path) for path in paths):
        digest.update(f"{rules}\n".encode())
    for scenario in sorted((one for path in paths for one in path.parent.glob("*.toml")), key=lambda one: one.name):
        digest.update(scenario.read_bytes())
    return {
        "swarmproof": digest.hexdigest()[:16],
        "python": platform.python_version(),
        **{name: version(name) for name in _LIBRARIES},
    }


def counts(told: Mapping[str, str]) -> bool:
    """Say whether what was `made_by` this is what our code would make: the same code, or one with the same numbers."""
    now = made_by()
    ours = (now["swarmproof"], *SAME_NUMBERS.get(now["swarmproof"], ()))
    return any(told == {**now, "swarmproof": digest} for digest in ours)


def modules() -> dict[str, Path]:
    """Return the modules of ours that measuring a cell needs, and where they are."""
    found: dict[str, Path] = {}
    waiting = [_ROOT]
    while waiting:
        name = waiting.pop()
        path = _module(name)
        if name not in found and path is not None:
            found[name] = path
            waiting.extend(_imported(path))
    return found


def _module(name: str) -> Path | None:
    """Return where the module of this name is; None if there is no such module, as for a name within one."""
    try:
        spec = find_spec(name)
    except ModuleNotFoundError:  # its parent is a module, no package
        return None
    return Path(spec.origin) if spec is not None and spec.origin is not None else None


def _imported(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module is not None and node.module.startswith("swarmproof"):
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _rules(path: Path) -> str:
    """Return what a module does, whatever it says about it, and wherever what it needs of ours is found."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    imported: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node) is not None:
            node.body = node.body[1:]
        for field in ("body", "orelse", "finalbody"):
            lines = getattr(node, field, None)
            if isinstance(lines, list):
                imported += [name for line in lines if _is_of_ours(line) for name in _names(line)]
                setattr(node, field, [line for line in lines if not _is_of_ours(line)])
    return f"{sorted(imported)} {ast.dump(tree)}"


def _is_of_ours(line: ast.stmt) -> bool:
    return isinstance(line, ast.ImportFrom) and (line.module or "").split(".")[0] == "swarmproof"


def _names(line: ast.stmt) -> Iterator[str]:
    """Yield what is imported, as it is called here; of a module, its text is looked at, and not its name."""
    assert isinstance(line, ast.ImportFrom)
    for alias in line.names:
        if _module(f"{line.module}.{alias.name}") is None:
            yield f"{alias.name} as {alias.asname or alias.name}"
