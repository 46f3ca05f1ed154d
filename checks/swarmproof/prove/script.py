"""What a reader can check: a short Python script for each counterexample, and the identity behind each certificate."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise, product
from math import lcm, prod

from swarmproof.algebra.grid import Range, Step
from swarmproof.algebra.polynomial import Number, Polynomial, Values, constant, variable
from swarmproof.algebra.statement import Condition, Sign, Solvable, Statement
from swarmproof.claims.proof import Question
from swarmproof.prove.evidence import Certificate, Evidence, Term, Unsolvable, Vectors, contradiction_statement
from swarmproof.prove.steps import Covered, Line

#: Lines of a script, besides the one that imports fractions; of these at most, for numbers and for a contradiction.
MOST_LINES, MOST_NUMBERS, MOST_SUMMANDS = 10, 2, 4
#: Characters up to which numbers are in one line.
WIDTH = 90
_IMPORT = "from fractions import Fraction as F"
_IS = {Sign.AT_LEAST: ">=", Sign.ABOVE: ">", Sign.EQUAL: "=="}
_NOT = {Sign.AT_LEAST: "<", Sign.ABOVE: "<=", Sign.EQUAL: "!="}
_ABOUT = {Sign.AT_LEAST: "at least 0", Sign.ABOVE: "more than 0", Sign.EQUAL: "equal to 0"}


def script(question: Question, evidence: Evidence | Covered | Line) -> str:
    """Return a script that shows the counterexample `evidence`: it needs Python only, and ends without an error.

    It has at most ten lines and, if there are fractions, one that imports them. A reader can change the numbers that
    are not zero; a condition in which there are none of these is left out.

    Returns:
        the script; empty if `evidence` proves the question, or does not check.
    """
    match question, evidence:
        case Statement(), Vectors() if evidence.fault(question) is None:
            return _with_import(_vectors(question, evidence.values))
        case Solvable(), Unsolvable() if evidence.fault(question) is None:
            return _with_import(_unsolvable(question, evidence))
        case Step(), Line() if evidence.fault(question) is None:
            return "\n".join(_line(question, evidence))
        case _:
            return ""


def identity(statement: Statement, certificate: Certificate) -> str:
    """Return the identity that proves `statement`, as an expression of Python but for names in brackets.

    Its first line is the left side; then each summand of the right side has a line; last, what the names stand for. If
    it is about differences of positions only, they are counted from the one of UAV i's old trajectory.
    """
    used = {name for each in (*certificate.terms, *certificate.multiplier) for name in each.hypotheses}
    named = [each for each in statement.hypotheses if each.name in used | certificate.equations.keys()]
    named.append(statement.conclusion)
    squares = (each.squared for each in (*certificate.terms, *certificate.multiplier))
    origin = _origin((*(each.value for each in named), *squares, *certificate.equations.values()))
    left = _in_names(certificate.multiplier, origin)
    before = "" if left == ["1"] else f"{left[0]}*" if len(left) == 1 else f"({' + '.join(left)})*"
    right = _in_names(certificate.terms, origin)
    right += [f"({by.put(origin)})*[{of}]" for of, by in certificate.equations.items()]
    return "\n".join(
        [
            f"{before}[{statement.conclusion.name}]",
            *(f"  {'+' if n else '='} {summand}" for n, summand in enumerate(right or ["0"])),
            "where, with positions counted from i_old," if origin else "where",
            *(f"  [{each.name}] is {each.value.put(origin)}, {_ABOUT[each.sign]}" for each in named),
        ]
    )


def _origin(polynomials: Collection[Polynomial]) -> dict[str, Polynomial | Number]:
    """Return that `i_old` is the origin, if none of the polynomials changes when all positions are shifted."""
    names = frozenset[str]().union(*(each.variables for each in polynomials))
    for axis in "xyz":
        shifted = {name: variable(name) + variable("i_old") for name in names if name.endswith(f"_{axis}")}
        if f"i_old_{axis}" not in names or any(each.put(shifted) != each for each in polynomials):
            return {}
    return {f"i_old_{axis}": 0 for axis in "xyz"}


def _in_names(terms: Iterable[Term], origin: dict[str, Polynomial | Number]) -> list[str]:
    """Return terms as products of hypotheses in brackets and a square."""
    texts = []
    for each in terms:
        factors = [f"[{name}]" for name in each.hypotheses]
        if each.squared not in (constant(1), constant(-1)):
            factors.append(f"({each.squared.put(origin)})**2")
        if each.factor != 1 or not factors:
            factors.insert(0, str(each.factor))
        texts.append("*".join(factors))
    return texts


def _vectors(statement: Statement, values: Values) -> list[str]:
    conclusion = statement.conclusion
    numbers, left = _numbers(values, (*statement.hypotheses, conclusion))
    broken = f"assert {_inequality(left(conclusion), _NOT)}  # not {conclusion.name}"
    return [*numbers, *_asserts(map(left, statement.hypotheses), MOST_LINES - len(numbers) - 1), broken]


def _unsolvable(problem: Solvable, evidence: Unsolvable) -> list[str]:
    """Return the numbers, and that multiples of constraints, none of them negative, add up to a negative number."""
    certificate = evidence.contradiction
    used = {name for each in certificate.terms for name in each.hypotheses} | certificate.equations.keys()
    constraints = [each for each in problem.constraints if each.name in used]
    numbers, left = _numbers(evidence.values, (*problem.hypotheses, *constraints))
    known = {each.name: left(each).value for each in constraints}
    summands = [
        *(
            (_product(each, known), f"{' times '.join(each.hypotheses) or 'a square'} is at least 0")
            for each in certificate.terms
        ),
        *((_times(Fraction(1), (by, known[of])), f"{of} is 0") for of, by in certificate.equations.items()),
    ]
    total = " + ".join(_product(each, known) for each in certificate.multiplier)
    first, *others = _packed(summands, " + ", MOST_SUMMANDS)
    lines = [f"assert {'-1' if total == '1' else f'-({total})'} == {'(' if others else ''}{first}"]
    lines += [f"    + {each}" for each in others]
    if others:
        lines[-1] = lines[-1].replace("  # ", ")  # ", 1)
    unknowns, degree = _degree(contradiction_statement(problem, evidence.values), certificate)
    if unknowns:
        lines = [_for_all(unknowns, degree), *(f"    {line}" for line in lines)]
    return [*numbers, *_asserts(map(left, problem.hypotheses), MOST_LINES - len(numbers) - len(lines)), *lines]


def _degree(contradiction: Statement, certificate: Certificate) -> tuple[list[str], int]:
    """Return the unknowns that are in a contradiction, and the degree of what is added up."""
    known = {each.name: each.value for each in contradiction.hypotheses}
    products = [
        *(prod((known[name] for name in each.hypotheses), start=each.squared**2) for each in certificate.terms),
        *(by * known[of] for of, by in certificate.equations.items()),
    ]
    degree = max((sum(e for _, e in monomial) for each in products for monomial in each.terms), default=0)
    return sorted(frozenset[str]().union(*(each.variables for each in products))), degree


def _for_all(unknowns: Sequence[str], degree: int) -> str:
    """Return a loop over places; a polynomial of this degree that is constant there is constant."""
    places = [place for place in product(range(degree + 1), repeat=len(unknowns)) if sum(place) <= degree]
    values = f"{places}" if len(unknowns) > 1 else f"range({degree + 1})"
    return f"for {', '.join(unknowns)} in {values}:  # degree {degree}: what is constant here is constant everywhere"


def _line(step: Step, evidence: Line) -> list[str]:
    horizon = evidence.horizon
    about = f"where UAV j is, by sample, in units of d̂_min; UAV i stays at 0; H = {horizon}"
    lines = [f"place = {dict(evidence.places)}  # {about}"]
    lines += [f"assert all(abs(place[s]) >= 1 for s in {_range(each, horizon)})  # {each.name}" for each in step.given]
    if step.rest is not None:
        rest = step.rest.at(horizon)
        lines.append(f"assert len({{place[s] for s in place if s >= {rest}}}) <= 1  # at rest from sample {rest} on")
    needed = _range(step.needed, horizon)
    return [*lines, f"assert any(abs(place[s]) < 1 for s in {needed})  # not {step.needed.name}"]


def _range(each: Range, horizon: int) -> str:
    return f"range({each.first.at(horizon)}, {each.last.at(horizon) + 1})"


def _numbers(values: Values, conditions: Collection[Condition]) -> tuple[list[str], Callable[[Condition], Condition]]:
    """Return lines that set the numbers which are not zero, and what puts the others into a condition."""
    names = frozenset[str]().union(*(each.value.variables for each in conditions))
    zeros = {name: Fraction(0) for name, value in values.items() if name in names and not value}
    items = [(f"{name} = {_fraction(value)}", "") for name, value in values.items() if name in names and value]
    short = sum(len(code) for code, _ in items) <= WIDTH
    lines = _packed(items, "; ", 1 if short else MOST_NUMBERS)
    if zeros:
        lines = [*lines[:-1], f"{lines[-1]}  # all others are 0" if items else "# all numbers are 0"]
    return lines, lambda condition: condition.put(dict(zeros))


def _asserts(conditions: Iterable[Condition], lines: int) -> list[str]:
    """Return at most so many lines that assert the conditions in which variables are left, each once."""
    names: dict[str, list[str]] = {}
    left = [each for each in conditions if each.value.variables]
    while left:
        first, *left = left
        if left and (both := _between(first, left[0])):
            names.setdefault(both, []).append(first.name[:-1].rstrip())
            left = left[1:]
        else:
            names.setdefault(_inequality(first, _IS), []).append(first.name)
    items = [(code, ", ".join(name for name in of if name != code)) for code, of in names.items()]
    return [f"assert {each}" for each in _packed(items, " and ", lines)]


def _between(low: Condition, high: Condition) -> str | None:
    """Return two conditions as ``low <= x <= high``, if their names say that they are the two ends of an interval."""
    if (low.name[:-1], low.name[-1], high.name[-1]) != (high.name[:-1], "≥", "≤"):
        return None
    scale = lcm(_denominator(low.value), _denominator(high.value))
    own, others = low.value.variables - high.value.variables, high.value.variables - low.value.variables
    least, most = -_part(low.value, own) * scale, _part(high.value, others) * scale
    between = low.value * scale + least
    return f"{least} <= {between} <= {most}" if high.value * scale == most - between else None


def _inequality(condition: Condition, signs: Mapping[Sign, str]) -> str:
    """Return a condition as Python, without fractions and without minus signs but in a square."""
    value = condition.value
    alone = Polynomial(
        {m: c for m, c in value.terms.items() if len(m) == 1 and len(_part(value, {m[0][0]}).terms) == 1}
    )
    square = _square(value - alone)
    factor, root = square or (Fraction(0), constant(0))
    kept = alone if square else value
    scale = lcm(_denominator(kept), factor.denominator)
    left, right = (
        str(Polynomial({m: abs(c) * scale for m, c in kept.terms.items() if (c > 0) is positive}))
        for positive in (True, False)
    )
    if factor > 0:
        left = _added(left, factor * scale, root)
    elif factor < 0:
        right = _added(right, -factor * scale, root)
    return f"{left} {signs[condition.sign]} {right}"


def _added(text: str, factor: Fraction, root: Polynomial) -> str:
    """Return an expression and a multiple of a square."""
    square = f"({root})**2" if factor == 1 else f"{factor}*({root})**2"
    return square if text == "0" else f"{text} + {square}"


def _square(polynomial: Polynomial) -> tuple[Fraction, Polynomial] | None:
    """Return c and q, which has no fractions, of a quadratic form that is c·q²; None if it is none."""
    for monomial, coefficient in polynomial.terms.items():
        if len(monomial) == 1 and monomial[0][1] == 2:
            name = monomial[0][0]
            others = _part(polynomial, {name}) - Polynomial({monomial: coefficient})
            root = variable(name) + others.put({name: 1}) / (2 * coefficient)
            scale = _denominator(root)
            return (coefficient / scale**2, root * scale) if coefficient * root**2 == polynomial else None
    return None


def _part(polynomial: Polynomial, variables: Collection[str]) -> Polynomial:
    """Return the terms in which one of these variables is."""
    return Polynomial({m: c for m, c in polynomial.terms.items() if any(name in variables for name, _ in m)})


def _packed(items: Sequence[tuple[str, str]], separator: str, lines: int) -> list[str]:
    """Return items, each with a comment, in at most so many lines, 1 or more: one each, or none longer than need be."""
    sizes = [len(code) + len(about) for code, about in items]
    starts = list(range(len(items)))
    for width in sorted({sum(sizes[a:b]) for b in starts for a in range(b)} | {sum(sizes)}):
        if len(starts) <= lines:
            break
        starts, size = [0], 0
        for n, each in enumerate(sizes):
            size += each
            if size > width and n:
                starts, size = [*starts, n], each
    return [_joined(items[a:b], separator) for a, b in pairwise([*starts, len(items)])]


def _joined(items: Sequence[tuple[str, str]], separator: str) -> str:
    code, comment = separator.join(code for code, _ in items), "; ".join(about for _, about in items if about)
    return f"{code}  # {comment}" if comment else code


def _product(each: Term, known: Mapping[str, Polynomial]) -> str:
    """Return a term as Python."""
    return _times(each.factor, (*(known[name] for name in each.hypotheses), each.squared, each.squared))


def _times(factor: Fraction, polynomials: Iterable[Polynomial]) -> str:
    """Return a product as Python, its polynomials without fractions."""
    written = []
    for each in polynomials:
        denominator = _denominator(each)
        factor /= denominator
        if each.variables:
            written.append(f"({each * denominator})")
        else:
            factor *= (each * denominator).at({})
    return "*".join([*([] if factor == 1 and written else [_fraction(factor)]), *written])


def _denominator(polynomial: Polynomial) -> int:
    return lcm(*(coefficient.denominator for coefficient in polynomial.terms.values()))


def _fraction(value: Fraction) -> str:
    return f"F({value.numerator}, {value.denominator})" if value.denominator > 1 else str(value.numerator)


def _with_import(lines: Sequence[str]) -> str:
    text = "\n".join(lines)
    return f"{_IMPORT}\n{text}" if "F(" in text else text
