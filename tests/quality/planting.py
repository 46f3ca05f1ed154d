"""Plants a bug into the model: one line of one of its modules is replaced while a test runs."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from types import FunctionType, ModuleType

import pytest


@dataclass(frozen=True)
class Edit:
    """One line of a module, and what stands there instead (an empty text: nothing)."""

    module: ModuleType
    old: str
    new: str

    def mutated_source(self) -> str:
        """Return the module's source with the line replaced; AssertionError unless it occurs exactly once."""
        assert "\n" not in self.old + self.new, "one line is replaced by one line"
        source = inspect.getsource(self.module)
        found = source.count(self.old)
        assert found == 1, f"{self.module.__name__} has {found} times {self.old!r}"
        return source.replace(self.old, self.new or "pass")


def plant(edit: Edit, monkeypatch: pytest.MonkeyPatch) -> None:
    """Give the module's functions and methods the code that they have with the line replaced.

    The functions stay the same objects, with the same globals: whoever has imported them, by name or through their
    module, runs the mutated code, and there is still only one class of every name.
    """
    mutated = ModuleType(f"{edit.module.__name__}, mutated")
    monkeypatch.setitem(sys.modules, mutated.__name__, mutated)  # dataclasses look their module up
    exec(compile(edit.mutated_source(), mutated.__name__, "exec"), mutated.__dict__)
    changed = 0
    for function, other in _functions(edit.module, mutated, edit.module.__name__):
        if other.__code__ != function.__code__:
            monkeypatch.setattr(function, "__code__", other.__code__)
            changed += 1
    assert changed, "the edit changes no function of the module"


def _functions(
    original: ModuleType | type, mutated: ModuleType | type, module: str
) -> Iterator[tuple[FunctionType, FunctionType]]:
    """Yield the functions of a module and the methods of its classes, each with the mutated one."""
    for name, function in list(vars(original).items()):
        if getattr(function, "__module__", None) != module:
            continue
        if isinstance(function, FunctionType):
            yield function, vars(mutated)[name]
        elif isinstance(function, type):
            yield from _functions(function, vars(mutated)[name], module)
