"""Evidence about one sample: identities around Cauchy-Schwarz, and small vectors."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from swarmproof.audit.evidence import Certificate, Evidence, Term, Vectors, term
from swarmproof.statements.polynomial import Number, Polynomial, Vector
from swarmproof.statements.separation import (
    D,
    D_POSITIVE,
    EQ_20,
    I_NEW,
    I_OLD,
    J_NEW,
    J_OLD,
    L,
    LENGTH,
    NOT_ZERO,
    OF_I,
    OF_J,
)

N = J_OLD - I_OLD


def cauchy_schwarz(w: Vector, surplus: tuple[Term, ...], rest: Polynomial | Number) -> Certificate:
    """Return the certificate of ‖w‖ ≥ d̂ from nᵀw ≥ d̂‖n‖.

    With l = ‖n‖ and s = nᵀw − ld: l²(‖w‖² − d²) = ‖n × w‖² + s² + 2lds, and `surplus` makes 2lds, up to `rest` times
    the equation l² = ‖n‖².
    """
    (a, b, c), (x, y, z) = N, w
    squares = [b * z - c * y, c * x - a * z, a * y - b * x, N.dot(w) - L * D]
    return Certificate(
        (*(term(squared=square) for square in squares), *surplus),
        {LENGTH: w.square + rest},
        (term(NOT_ZERO, NOT_ZERO),),
    )


def _both_new() -> Certificate:
    surplus = (term(D_POSITIVE, NOT_ZERO, OF_I), term(D_POSITIVE, NOT_ZERO, OF_J))
    return cauchy_schwarz(J_NEW - I_NEW, surplus, 2 * L * D)


def _one_new() -> Certificate:
    return cauchy_schwarz(J_OLD - I_NEW, (term(D_POSITIVE, NOT_ZERO, OF_I, factor=2),), 0)


def vectors(d: Number, l: Number | None = None, **places: tuple[Number, Number, Number]) -> Vectors:
    """Return numbers for the variables: distances, and positions by name."""
    values = {f"{name}_{axis}": Fraction(x) for name, place in places.items() for axis, x in zip("xyz", place, strict=True)}
    values["d"] = Fraction(d)
    if l is not None:
        values["l"] = Fraction(l)
    return Vectors(values)


_TOO_CLOSE = vectors(1, Fraction(1, 2), i_old=(0, 0, 0), j_old=(Fraction(1, 2), 0, 0), i_new=(Fraction(-1, 4), 0, 0))

EVIDENCE: Mapping[str, Mapping[str, Evidence]] = {
    "corollary-1/printed": {"both new": _both_new()},
    "lemma-3/printed": {"j is not in A_ET(k)": _one_new(), "j is in A_ET(k)": _TOO_CLOSE},
}
