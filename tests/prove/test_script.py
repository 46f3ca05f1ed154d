"""Scripts for readers: short, without this project, and wrong as soon as a number is; identities are identities."""

from __future__ import annotations

import re
import subprocess
import sys
from fractions import Fraction

import pytest
from tests.dmpc_swarm.proofs.filed import FILED, Filed, answers

from swarmproof.algebra.grid import Range, Step, Time
from swarmproof.algebra.polynomial import Polynomial, constant, variables
from swarmproof.algebra.statement import Solvable, Statement, above, at_least, equal
from swarmproof.claims.proof import ProofVerdict, Question
from swarmproof.prove.decide import Shown
from swarmproof.prove.evidence import Candidate, Certificate, Unsolvable, Vectors, term
from swarmproof.prove.script import MOST_LINES, identity, script
from swarmproof.prove.steps import Covered, Line

REFUTED = {name: one for name, one in FILED.items() if one.refutes}
F = Fraction
A, B, U, V = variables("a b u v")


def code(one: Filed) -> str:
    """Return the script of a question."""
    assert one.evidence is not None
    return script(one.asked, one.evidence)


def runs(text: str) -> bool:
    """Say whether a script ends without a failed assertion, here."""
    try:
        exec(text, {})
    except AssertionError:
        return False
    return True


@pytest.mark.parametrize("name", REFUTED)
def test_every_counterexample_has_a_short_script(name: str) -> None:
    """What is false has at most ten lines of Python, besides an import of the standard library, that end well."""
    lines = code(REFUTED[name]).splitlines()
    imports = [line for line in lines if "import" in line]
    assert imports in ([], ["from fractions import Fraction as F"])
    assert 2 <= len(lines) - len(imports) <= MOST_LINES
    assert runs(code(REFUTED[name]))


def test_scripts_need_nothing_but_python() -> None:
    """Every script, by itself in an interpreter that knows nothing of this project, ends with exit code 0."""
    for text in {code(one) for one in REFUTED.values()}:
        done = subprocess.run([sys.executable, "-I", "-S", "-c", text], capture_output=True, text=True, check=False)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", ""), text


@pytest.mark.parametrize("name", [name for name, one in REFUTED.items() if isinstance(one.evidence, Vectors)])
def test_a_script_with_another_number_ends_as_the_check_does(name: str) -> None:
    """Whichever number is altered, the script fails if and only if the numbers no longer refute the statement."""
    asked, evidence = REFUTED[name].asked, REFUTED[name].evidence
    assert isinstance(asked, Statement)
    assert isinstance(evidence, Vectors)
    failed = []
    for number, value in evidence.values.items():
        text = f"\n{code(REFUTED[name])}"
        assigned = rf"(?<=[\n ]){number} = [^;\n ]*(?: \d+\))?"
        if len(re.findall(assigned, text)) != 1:
            # zeros are not in it, nor what does not occur
            continue
        for other in (value + 1, -value, value / 3):
            altered = re.sub(assigned, f"{number} = __import__('fractions').Fraction('{other}')", text)
            fault = Vectors({**evidence.values, number: other}).fault(asked)
            assert runs(altered) == (fault is None), (number, other, altered)
            failed.append(fault is not None)
    assert any(failed)


@pytest.mark.parametrize("name", [name for name, one in REFUTED.items() if not isinstance(one.evidence, Vectors)])
def test_a_script_with_a_wrong_number_fails(name: str) -> None:
    """Some number, when it is altered, makes the script of a contradiction or of a line fail."""
    text = code(REFUTED[name])
    failed = []
    for number in re.finditer(r"(?:= |: |\(|, )(-?\d+)(?=[,;)}\n ])", text.partition("assert")[0]):
        altered = text[: number.start(1)] + str(int(number[1]) + 7) + text[number.end(1) :]
        failed.append(not runs(altered))
    # the places of a line are all 0 or 1: those that have to be 1
    if isinstance(REFUTED[name].evidence, Line):
        failed.append(not runs(re.sub(r": 1", ": 0", text)) or not runs(re.sub(r": 0", ": 1", text)))
    assert any(failed)


def test_what_is_proved_has_no_script() -> None:
    """Trying numbers is no proof: there is no script for any of it; and what is on file decides as its kind says."""
    proved = {name for name, one in FILED.items() if not one.refutes}
    assert len(proved) > 300
    assert {name for name in proved if code(FILED[name]) != ""} == set()
    decided = {name: one.verdict for name, one in answers().items()}
    assert decided == {name: ProofVerdict.PROVED if name in proved else ProofVerdict.FALSE for name in FILED}


STATEMENT = Statement((at_least("a >= 1", A, 1), equal("b is a", B, A)), above("ab > 1", A * B, 1))
PROBLEM = Solvable((at_least("a >= 0", A),), ("u", "v"), (at_least("low", U + V, 1), at_least("high", A - V, U)))
STEP = Step((Range("given", Time(1), Time(2)),), Range("needed", Time(1), Time(3)), Time(3))


@pytest.mark.parametrize(
    ("question", "evidence"),
    [
        (STATEMENT, Vectors({"a": F(2), "b": F(2)})),
        (STATEMENT, Vectors({"a": F(1)})),
        (PROBLEM, Vectors({"a": F(1), "b": F(1)})),
        (PROBLEM, Unsolvable({"a": F(1)}, Certificate((term("low"), term("high"))))),
        (STATEMENT, Certificate()),
        (PROBLEM, Candidate({}, ())),
        (STEP, Line(1, {1: 1, 2: 1, 3: 1})),
        (STEP, Covered((), False)),
        (STEP, Vectors({})),
    ],
)
def test_evidence_that_does_not_check_has_no_script(question: Question, evidence: Shown) -> None:
    """What refutes nothing, or something else, is not shown as if it did."""
    assert script(question, evidence) == ""


def test_how_a_script_of_numbers_reads() -> None:
    """Numbers, each hypothesis with its name, and the conclusion that fails."""
    statement = Statement((*STATEMENT.hypotheses, at_least("zero", variables("z").__next__())), STATEMENT.conclusion)
    assert script(statement, Vectors({"a": F(1), "b": F(1), "z": F(0)})).splitlines() == [
        "a = 1; b = 1  # all others are 0",
        "assert a >= 1",
        "assert b == a  # b is a",
        "assert a*b <= 1  # not ab > 1",
    ]


def test_how_a_script_of_a_contradiction_reads() -> None:
    """Multiples of constraints add up to −1, whatever the unknowns are, of which enough are tried."""
    evidence = Unsolvable({"a": F(1, 2)}, Certificate((term("low", factor=2), term("high", factor=2))))
    assert script(PROBLEM, evidence).splitlines() == [
        "from fractions import Fraction as F",
        "a = F(1, 2)",
        "assert a >= 0",
        "for u, v in [(0, 0), (0, 1), (1, 0)]:  # degree 1: what is constant here is constant everywhere",
        "    assert -1 == (2*(u + v - 1)  # low is at least 0",
        "        + 2*(a - u - v))  # high is at least 0",
    ]


def test_unknowns_of_higher_degree() -> None:
    """Squares and products of unknowns are tried at as many points as their degree asks for."""
    square = Solvable((), ("u", "v"), (at_least("negative", -1 - U**2 + 2 * U * V - V**2),))
    text = script(square, Unsolvable({}, Certificate((term("negative"), term(squared=U - V)))))
    assert "[(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (2, 0)]" in text
    assert "# a square is at least 0" in text
    assert runs(text)
    assert not runs(text.replace("u**2", "3*u**2"))


def test_how_a_script_of_a_line_reads() -> None:
    """Places by sample, what is given, rest, and what is not apart."""
    text = script(STEP, Line(1, {1: 1, 2: 1, 3: 0}))
    assert text.splitlines()[1:] == [
        "assert all(abs(place[s]) >= 1 for s in range(1, 3))  # given",
        "assert len({place[s] for s in place if s >= 3}) <= 1  # at rest from sample 3 on",
        "assert any(abs(place[s]) < 1 for s in range(1, 4))  # not needed",
    ]
    assert text.startswith("place = {1: 1, 2: 1, 3: 0}  # where UAV j is")


def test_many_hypotheses_share_lines() -> None:
    """However many hypotheses there are, each is asserted once, and the two ends of an interval together."""
    names = [f"x{n}" for n in range(20)]
    low, high = variables("low high")
    hypotheses = tuple(
        condition
        for name, x in zip(names, variables(" ".join(names)), strict=True)
        for condition in (at_least(f"{name} ≥", x / 2, low), at_least(f"{name} ≤", high, x / 2))
    )
    values = {**{name: F(n + 2) for n, name in enumerate(names)}, "low": F(1, 2), "high": F(11)}
    text = script(Statement(hypotheses, at_least("false", low, high)), Vectors(values))
    assert len(text.splitlines()) == 1 + MOST_LINES
    assert all(f"2*low <= {name} <= 2*high" in text for name in names)
    assert runs(text)
    assert not runs(text.replace("x7 = 9", "x7 = 0"))


CERTIFIED = {
    name: (one.asked, one.evidence)
    for name, one in FILED.items()
    if isinstance(one.asked, Statement) and isinstance(one.evidence, Certificate)
}


@pytest.mark.parametrize("name", CERTIFIED)
def test_identities_are_identities(name: str) -> None:
    """With what its names stand for put in, both sides of a printed identity have the same value everywhere."""
    asked, evidence = CERTIFIED[name]
    text = identity(asked, evidence)
    both, _, stand_for = text.partition("\nwhere")
    for number, line in enumerate(stand_for.splitlines()[1:]):
        bracket, of, value = line.strip().partition("] is ")
        assert of, number
        both = both.replace(f"{bracket}]", f"({re.sub(', (at least|more than|equal to) 0$', '', value)})")
    assert "[" not in both
    left, right = re.sub(r"(?<![\w.])(\d+)", r"F(\1)", both).split("\n  = ")
    for seed in range(3):
        values = {each: F((7 * n + 5 * seed) % 11 - 4, n % 3 + 1) for n, each in enumerate(sorted(_names(asked)))}
        scope = {"F": F, **values}
        assert eval(f"({left}) - ({right})".replace("\n", " "), scope) == 0


def _names(asked: Statement) -> frozenset[str]:
    return frozenset[str]().union(*(each.value.variables for each in (*asked.hypotheses, asked.conclusion)))


def test_how_an_identity_reads() -> None:
    """The multiplier times the conclusion, then the summands, then the names."""
    statement = Statement((above("a > 0", A), equal("b is 1", B, 1)), at_least("ab >= a", A * B, A))
    certificate = Certificate((term("a > 0", squared=A, factor=0),), {"b is 1": A**2}, (term("a > 0"),))
    assert certificate.fault(statement) is None
    assert identity(statement, certificate).splitlines() == [
        "[a > 0]*[ab >= a]",
        "  = 0*[a > 0]*(a)**2",
        "  + (a**2)*[b is 1]",
        "where",
        "  [a > 0] is a, more than 0",
        "  [b is 1] is b - 1, equal to 0",
        "  [ab >= a] is a*b - a, at least 0",
    ]
    trivial: Polynomial = constant(0)
    assert identity(Statement((), at_least("0 >= 0", trivial)), Certificate()).splitlines()[:2] == ["[0 >= 0]", "  = 0"]
