"""Writes docs/mutants.md from what is generated, and from the sentences: python -m tests.quality.document."""

from __future__ import annotations

from pathlib import Path

from tests.quality.equal import EQUAL
from tests.quality.mutation import mutants_of
from tests.quality.suites import SUITES, UNFINISHED

PAGE = Path(__file__).parents[2] / "docs" / "mutants.md"
_MARK = "<!-- what follows is written by python -m tests.quality.document -->"


def tables() -> str:
    """Return the tables: how many mutants each module has, and each one that is equal with its sentence."""
    numbers = ["| module | mutants | killed | equal | tests that concern it |", "| --- | ---: | ---: | ---: | --- |"]
    sentences: list[str] = []
    total = [0, 0]
    for module, stages in SUITES.items():
        count, equal = len(mutants_of(module)), EQUAL.get(module, {})
        if module not in UNFINISHED:
            total = [total[0] + count, total[1] + len(equal)]
        files = dict.fromkeys(argument for stage in stages for argument in stage if argument.endswith(".py"))
        tests = ", ".join(f"`{file.removeprefix('tests/')}`" for file in files)
        killed = "not all run yet" if module in UNFINISHED else str(count - len(equal))
        numbers.append(f"| `{module}` | {count} | {killed} | {len(equal)} | {tests} |")
        if equal:
            sentences += ["", f"### `{module}`", ""]
        for sentence in dict.fromkeys(equal.values()):
            names = [name for name, why in equal.items() if why == sentence]
            sentences += [f"- {sentence}", *(f"    - `{name}`" for name in names)]
    numbers.append(f"| all that were run | {total[0]} | {total[0] - total[1]} | {total[1]} | |")
    return "\n".join([_MARK, "", "## How many", "", *numbers, "", "## Equal, and why", *sentences, ""])


def page(text: str) -> str:
    """Return the page with its tables written anew."""
    return text[: text.index(_MARK)] + tables()


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
