"""Every single-place change of a module: the mutants that `make mutants` runs the tests against (docs/mutants.md)."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from types import CodeType

#: A name of a mutant shows the largest expression around the change that is not longer.
SHOWN = 70

COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Add,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.Pow: ast.Mult,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
_PAIRS = [
    ("min", "max"),
    ("any", "all"),
    ("floor", "ceil"),
    ("minimum", "maximum"),
    ("argmin", "argmax"),
    ("gcd", "lcm"),
]
#: Functions and methods in whose place another one is called; abs is left out instead.
CALLED = {**dict(_PAIRS), **{b: a for a, b in _PAIRS}, "popleft": "pop"}

COMPOUND = (ast.FunctionDef, ast.ClassDef, ast.If, ast.For, ast.While, ast.With, ast.Try)
#: In what is read by people and type checkers nothing is changed, nor in the messages of errors.
UNCHANGED = (ast.arg, ast.JoinedStr, ast.Raise, ast.Assert, ast.Import, ast.ImportFrom)


@dataclass(frozen=True)
class Mutant:
    """A module with one place changed.

    Attributes:
        name: function: expression => what it becomes; with a number if a function has that change several times.
            It does not depend on what stands elsewhere in the module.
    """

    module: str
    name: str
    _tree: ast.Module
    _parent: ast.AST
    _field: str
    _index: int | None
    _new: ast.AST

    @contextmanager
    def _applied(self) -> Iterator[None]:
        old = getattr(self._parent, self._field)
        if self._index is None:
            setattr(self._parent, self._field, self._new)
        else:
            setattr(self._parent, self._field, [*old[: self._index], self._new, *old[self._index + 1 :]])
        try:
            yield
        finally:
            setattr(self._parent, self._field, old)

    def code(self) -> CodeType:
        """Return the code of the whole module with the change."""
        with self._applied():
            return compile(ast.fix_missing_locations(self._tree), f"<{self.module}, mutated>", "exec")

    def shown(self, node: ast.AST) -> str:
        """Return the text of a node with the change."""
        with self._applied():
            return ast.unparse(node)


def source_of(module: str) -> str:
    """Return the text of a module's file, without loading the module."""
    spec = find_spec(module)
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).read_text(encoding="utf-8")


def mutants_of(module: str, source: str | None = None) -> dict[str, Mutant]:
    """Return the mutants of a module by name, in the order of its places; `source` stands for the module's file."""
    tree = ast.parse(source_of(module) if source is None else source)
    found: dict[str, Mutant] = {}
    seen: Counter[str] = Counter()
    for ancestors, field, index, new in _changes(tree, ()):
        mutant = Mutant(module, "", tree, ancestors[-1], field, index, new)
        around, itself = _shown_around(ancestors, field, index)
        after = ast.unparse(new) if itself else mutant.shown(around)
        name = f"{_function(ancestors)}: {_line(ast.unparse(around))} => {_line(after)}"
        seen[name] += 1
        name += f" #{seen[name]}" if seen[name] > 1 else ""
        found[name] = replace(mutant, name=name)
    return found


def _line(text: str) -> str:
    return " ".join(text.split())


def _function(ancestors: tuple[ast.AST, ...]) -> str:
    named = (ast.FunctionDef, ast.ClassDef)
    return ".".join(node.name for node in ancestors if isinstance(node, named)) or "(module)"


def _shown_around(ancestors: tuple[ast.AST, ...], field: str, index: int | None) -> tuple[ast.AST, bool]:
    """Return the largest expression or statement around a change that is short enough, else the smallest one.

    Also whether that is the node itself that is replaced.
    """
    value = getattr(ancestors[-1], field)
    chain = [*ancestors, value if index is None else value[index]]
    units = [node for node in chain if isinstance(node, ast.expr | ast.stmt | ast.comprehension)]
    shown = units[-1]
    for node in reversed(units):
        if isinstance(node, COMPOUND):
            break
        if len(_line(ast.unparse(node))) <= SHOWN:
            shown = node
    return shown, shown is chain[-1]


_Change = tuple[tuple[ast.AST, ...], str, "int | None", ast.AST]


def _changes(node: ast.AST, ancestors: tuple[ast.AST, ...]) -> Iterator[_Change]:
    """Yield (ancestors, the last one's field, index in it, what is put there) of every change in `node`."""
    here = (*ancestors, node)
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list"):
            continue
        for index, child in enumerate(value) if isinstance(value, list) else [(None, value)]:
            if not isinstance(child, ast.AST) or isinstance(child, UNCHANGED) or _left_out(child, node, field):
                continue
            for new in _instead_of(child, node, field):
                yield here, field, index, new
            yield from _changes(child, here)


def _left_out(child: ast.AST, parent: ast.AST, field: str) -> bool:
    """Say whether a node is only a type, or the `strict` of a zip, which is an assertion."""
    if isinstance(child, ast.keyword):
        return child.arg == "strict"
    if isinstance(parent, ast.Module) and isinstance(child, ast.Assign):
        return not any(isinstance(one, ast.Constant) and isinstance(one.value, int) for one in ast.walk(child.value))
    # dict[str, int](), an instance of a generic class
    return isinstance(child, ast.Subscript) and isinstance(parent, ast.Call) and field == "func"


def _instead_of(node: ast.AST, parent: ast.AST, field: str) -> Iterator[ast.AST]:
    """Yield what is put in the place of a node."""
    if isinstance(node, ast.cmpop):
        yield COMPARISONS[type(node)]()
    elif isinstance(node, ast.operator) and type(node) in OPERATORS:
        yield OPERATORS[type(node)]()
    elif isinstance(node, ast.boolop):
        yield ast.Or() if isinstance(node, ast.And) else ast.And()
    elif isinstance(node, ast.UnaryOp):
        yield node.operand
    elif isinstance(node, ast.Constant) and not isinstance(parent, ast.Expr):
        if isinstance(node.value, bool):
            yield ast.Constant(not node.value)
        elif isinstance(node.value, int | float):
            yield ast.Constant(node.value + 1)
    elif isinstance(node, ast.Name) and node.id in CALLED and isinstance(parent, ast.Call):
        yield ast.Name(CALLED[node.id], ast.Load())
    elif isinstance(node, ast.Attribute) and node.attr in CALLED and isinstance(parent, ast.Call) and field == "func":
        yield ast.Attribute(node.value, CALLED[node.attr], ast.Load())
    elif isinstance(node, ast.IfExp):
        yield from (node.body, node.orelse)
    elif isinstance(node, ast.Call) and ast.unparse(node.func) in ("abs", "np.abs"):
        yield node.args[0]
    elif (isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)) or isinstance(
        node, ast.Break | ast.Continue
    ):
        yield ast.Pass()
    if field == "test" and isinstance(parent, ast.If):
        yield ast.Constant(False)
    if field == "ifs":
        yield ast.Constant(True)
