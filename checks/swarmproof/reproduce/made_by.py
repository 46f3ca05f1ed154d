"""What numbers depend on beside their cell: our code and the libraries' versions. Others' results are not mixed in."""

from __future__ import annotations

import ast
import hashlib
import platform
from collections.abc import Iterator
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

_ROOT = "swarmproof.reproduce.measure"
_LIBRARIES = ("numpy", "piqp", "scipy")


@cache
def made_by() -> dict[str, str]:
    """Return what identifies the code that flies and measures a cell: a digest of ours, and versions of others'.

    The digest is over all modules that :mod:`swarmproof.reproduce.measure` needs, without comments and docstrings, and
    over the scenarios that ship.
    """
    digest = hashlib.sha256()
    for name, path in sorted(modules().items()):
        digest.update(f"{name}\n{_rules(path)}\n".encode())
        if name == "swarmproof.scenario.scenario":
            for scenario in sorted(path.parent.glob("*.toml")):
                digest.update(scenario.read_bytes())
    return {
        "swarmproof": digest.hexdigest()[:16],
        "python": platform.python_version(),
        **{name: version(name) for name in _LIBRARIES},
    }


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
    """Return what a module does, whatever it says about it."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node) is not None:
            node.body = node.body[1:]
    return ast.dump(tree)
