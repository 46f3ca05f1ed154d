"""The mutants of `make mutants`: what is generated, what runs against them, and that table and page agree with it."""

from __future__ import annotations

import signal
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from tests.quality import document, run_mutants
from tests.quality.equal import EQUAL, read
from tests.quality.mutation import mutants_of
from tests.quality.suites import SUITES

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("module", SUITES)
def test_every_sentence_is_about_a_mutant(module: str) -> None:
    """Each equal mutant is generated; so a sentence about a line that has changed is noticed."""
    assert not EQUAL.get(module, {}).keys() - mutants_of(module).keys()


def test_the_table_is_about_modules_with_tests() -> None:
    """No sentence is about another module, and every test file that is named exists."""
    assert EQUAL.keys() <= SUITES.keys()
    files = {argument for stages in SUITES.values() for stage in stages for argument in stage if "/" in argument}
    assert len(files) >= 10
    assert not [file for file in files if not (ROOT / file).is_file()]


def test_the_page_agrees_with_what_is_generated() -> None:
    """docs/mutants.md has the numbers and sentences of now: `python -m tests.quality.document` writes them."""
    text = document.PAGE.read_text(encoding="utf-8")
    assert document.page(text) == text


def test_a_sentence_is_there_once_and_ends() -> None:
    """A mutant that has two sentences, and a sentence without an end, are refused."""
    entry = '[[equal]]\nmodule = "a"\nwhy = "{}"\nmutants = ["one"]\n'
    assert read(entry.format("It is so.")) == {"a": {"one": "It is so."}}
    with pytest.raises(AssertionError, match="twice"):
        read(entry.format("It is so.") * 2)
    with pytest.raises(AssertionError):
        read(entry.format("so"))


SOURCE = '''
"""A text is left alone: 1 < 2."""

LIMIT = 3
Names = tuple[int | str, ...]


def least(values: list[int]) -> int | None:
    """Return 1."""
    if not values or LIMIT == 0:
        return None
    assert LIMIT > 0, "not 0"
    kept = [abs(v) for v in values if v < LIMIT]
    kept.sort(reverse=True)
    for value in zip(kept, kept, strict=True):
        if value is None:
            continue
        raise ValueError(f"{1 + 1}")
    return min(kept) - LIMIT if any(kept) else -1
'''
TEST = "not values or LIMIT == 0"
KEPT = "kept = [abs(v) for v in values if v < LIMIT]"
RETURN = "return min(kept) - LIMIT if any(kept) else -1"


def test_every_kind_of_change_is_made_once() -> None:
    """Comparisons, operators, signs, constants, names and statements are changed; types, texts and messages are not."""
    expected = [
        ("(module)", "LIMIT = 3", ["LIMIT = 4"]),
        (
            "least",
            TEST,
            [
                "False",
                "not values and LIMIT == 0",
                "values or LIMIT == 0",
                "not values or LIMIT != 0",
                "not values or LIMIT == 1",
            ],
        ),
        ("least", KEPT, [KEPT.replace("abs(v)", "v"), KEPT.replace("v < LIMIT", "True"), KEPT.replace("<", "<=")]),
        ("least", "kept.sort(reverse=True)", ["pass", "kept.sort(reverse=False)"]),
        ("least", "value is None", ["False", "value is not None"]),
        ("least", "continue", ["pass"]),
        (
            "least",
            RETURN,
            [
                "return min(kept) - LIMIT",
                "return -1",
                RETURN.replace("any", "all"),
                RETURN.replace("min", "max"),
                RETURN.replace("- LIMIT", "+ LIMIT"),
                RETURN.replace("-1", "1"),
                RETURN.replace("-1", "-2"),
            ],
        ),
    ]
    names = {f"{function}: {old} => {new}" for function, old, news in expected for new in news}
    assert mutants_of("made.up", SOURCE).keys() == names


def test_a_name_does_not_depend_on_other_lines() -> None:
    """Lines before and after do not change a name; two equal changes in one function are told apart by a number."""
    before = mutants_of("made.up", SOURCE)
    moved = mutants_of("made.up", SOURCE.replace("LIMIT = 3", "import math\n\nLIMIT = 3") + "\n\nMORE = 1\n")
    assert moved.keys() - before.keys() == {"(module): MORE = 1 => MORE = 2"}
    assert before.keys() <= moved.keys()
    twice = "def f(a: int) -> bool:\n    a = 1 + a\n    a = 1 + a\n    return a > 1\n"
    assert "f: a = 1 + a => a = 1 - a #2" in mutants_of("made.up", twice)


def test_a_mutant_is_the_module_with_one_change() -> None:
    """The code of a mutant does what its name says, and making it leaves the others as they are."""
    mutants = mutants_of("made.up", SOURCE)
    for name, argument, answer in (
        (f"least: {KEPT} => {KEPT.replace('<', '<=')}", [3], 0),
        (f"least: {TEST} => values or LIMIT == 0", [3], None),
        (f"least: {RETURN} => return -1", [3], -1),
    ):
        made: dict[str, Any] = {"zip": lambda *_, strict: []}
        exec(mutants[name].code(), made)
        assert made["least"](argument) == answer


@pytest.mark.parametrize(
    ("fates", "sentences", "wrong", "said"),
    [
        ({"a": "killed", "b": "survived"}, {"b": "So."}, False, "2 mutants, 1 killed (0 by never ending), 1 equal, 0"),
        ({"a": "killed by never ending", "b": "killed"}, {}, False, "2 killed (1 by never ending), 0 equal, 0 surv"),
        ({"a": "killed", "b": "survived"}, {}, True, "survived, and no sentence says why: b"),
        ({"a": "killed", "b": "killed"}, {"b": "So."}, True, "has a sentence that says it is equal, but is killed: b"),
        ({"a": "killed", "b": "killed"}, {"c": "So."}, True, "has a sentence, but is no mutant any more: c"),
    ],
)
def test_what_is_wrong_is_said(
    fates: dict[str, str], sentences: dict[str, str], wrong: bool, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A survivor without a sentence, and a sentence without a survivor, are wrong, and named."""
    campaign: Any = SimpleNamespace(module="made.up", mutants=dict.fromkeys(fates), fates=fates)
    assert run_mutants.says(campaign, sentences) is wrong
    assert said in capsys.readouterr().out


def test_what_became_of_a_mutant_is_told_by_how_its_tests_end() -> None:
    """Failed tests kill, passed ones do not; a limit of processor time is one that was used up, by any clock."""
    exited, killed, exceeded = 1 << 8, int(signal.SIGKILL), int(signal.SIGXCPU)
    assert run_mutants.fate_of(0, 1.0, 30) == run_mutants.SURVIVED
    assert [run_mutants.fate_of(code * exited, 1.0, 30) for code in (1, 2, 3)] == [run_mutants.KILLED] * 3
    assert run_mutants.fate_of(int(signal.SIGSEGV), 1.0, 30) == run_mutants.KILLED
    assert [run_mutants.fate_of(one, 30.2, 30) for one in (killed, exceeded)] == [run_mutants.NEVER_ENDS] * 2
    for status in (killed, 4 * exited, 5 * exited, 70 * exited):
        with pytest.raises(SystemExit):
            run_mutants.fate_of(status, 1.0, 30)
