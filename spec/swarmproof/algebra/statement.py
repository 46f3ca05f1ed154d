"""What the proofs of DMPC-Swarm state, as formulas over real numbers.

A :class:`Statement` says that conditions imply another, for all reals. A :class:`Solvable` says that, where conditions
hold, others can be met by a choice of some variables: that an optimization problem is feasible. A statement knows
nothing of how it is proved or refuted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

from swarmproof.algebra.polynomial import Number, Polynomial, Values, as_polynomial


class Sign(StrEnum):
    """What a condition says of its polynomial."""

    AT_LEAST = ">="
    ABOVE = ">"
    EQUAL = "=="


@dataclass(frozen=True, slots=True)
class Condition:
    """``value >= 0``, ``value > 0`` or ``value == 0``; `name` says what it is, and where in the paper."""

    name: str
    value: Polynomial
    sign: Sign = Sign.AT_LEAST

    def holds(self, values: Values) -> bool:
        """Decide the condition, exactly, where the variables have these values."""
        value = self.value.at(values)
        if self.sign is Sign.EQUAL:
            return value == 0
        return value > 0 if self.sign is Sign.ABOVE else value >= 0

    def put(self, replaced: dict[str, Polynomial | Number]) -> Condition:
        """Return the condition with these variables replaced."""
        return replace(self, value=self.value.put(replaced))


def at_least(name: str, left: Polynomial | Number, right: Polynomial | Number = 0) -> Condition:
    """Return the condition left ≥ right."""
    return Condition(name, as_polynomial(left) - right)


def above(name: str, left: Polynomial | Number, right: Polynomial | Number = 0) -> Condition:
    """Return the condition left > right."""
    return Condition(name, as_polynomial(left) - right, Sign.ABOVE)


def equal(name: str, left: Polynomial | Number, right: Polynomial | Number = 0) -> Condition:
    """Return the condition left = right."""
    return Condition(name, as_polynomial(left) - right, Sign.EQUAL)


@dataclass(frozen=True, slots=True)
class Statement:
    """For all real values of the variables: if all hypotheses hold, the conclusion holds. Hypotheses have own names."""

    hypotheses: tuple[Condition, ...]
    conclusion: Condition

    def without(self, *names: str) -> Statement:
        """Return the statement without the hypotheses of these names.

        Raises:
            KeyError: there is no hypothesis of one of the names.
        """
        for name in names:
            if name not in {hypothesis.name for hypothesis in self.hypotheses}:
                raise KeyError(name)
        return replace(self, hypotheses=tuple(h for h in self.hypotheses if h.name not in names))


@dataclass(frozen=True, slots=True)
class Solvable:
    """For all reals for which the hypotheses hold, `unknowns` exist for which all constraints hold."""

    hypotheses: tuple[Condition, ...]
    unknowns: tuple[str, ...]
    constraints: tuple[Condition, ...]
