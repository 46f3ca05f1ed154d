"""Evidence about one sample: identities around Cauchy-Schwarz, and small vectors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

from swarmproof.algebra.polynomial import Number, Polynomial, Vector, constant, variable
from swarmproof.dmpc_swarm.proofs.terms.cells import Cell, cells
from swarmproof.dmpc_swarm.proofs.terms.separation import (
    D_POSITIVE,
    EQ_20,
    I_NEW,
    I_OLD,
    J_NEW,
    J_OLD,
    LENGTH,
    NOT_ZERO,
    OF_I,
    OF_J,
    D,
    L,
)
from swarmproof.prove.evidence import Candidate, Certificate, Evidence, Term, Unsolvable, Vectors, term

_HALF = Fraction(1, 2)
_N = J_OLD - I_OLD
_SOFT = variable("epsilon")


def _squares(w: Vector) -> Iterator[Polynomial]:
    """Yield what is squared in n²‖w‖² − l²d² = ‖n × w‖² + s² + 2lds, where s = nᵀw − ld (Lagrange)."""
    (a, b, c), (x, y, z) = _N, w
    yield from (b * z - c * y, c * x - a * z, a * y - b * x, _N.dot(w) - L * D)


def cauchy_schwarz(w: Vector, surplus: tuple[Term, ...], equation: Polynomial | Number) -> Certificate:
    """Return the certificate of ‖w‖ ≥ d̂ from nᵀw ≥ d̂‖n‖: l²(‖w‖² − d²) is a sum of squares and 2lds.

    Args:
        w: the vector whose length is in question.
        surplus: terms that make 2lds, with s = nᵀw − ld, up to
        equation: times l² − ‖n‖².
    """
    squares = tuple(term(squared=square) for square in _squares(w))
    return Certificate((*squares, *surplus), {LENGTH: w.square + equation}, (term(NOT_ZERO, NOT_ZERO),))


#: Both planes together say 2s ≥ 0; the soft constraint of Appendix B adds 2lε for each plane.
BOTH_NEW = cauchy_schwarz(
    J_NEW - I_NEW, (term(D_POSITIVE, NOT_ZERO, OF_I), term(D_POSITIVE, NOT_ZERO, OF_J)), 2 * L * D
)
#: The plane close to j says s ≥ 0.
ONE_NEW = cauchy_schwarz(J_OLD - I_NEW, (term(D_POSITIVE, NOT_ZERO, OF_I, factor=2),), 0)
_W = J_OLD - I_NEW
#: The halfway plane says 2s ≥ l(d − l) and (20) that l ≥ d; everything is multiplied by l + d, for l² − d² is (20).
ONE_NEW_HALFWAY = Certificate(
    (
        *(term(positive, squared=square) for positive in (NOT_ZERO, D_POSITIVE) for square in _squares(_W)),
        term(NOT_ZERO, NOT_ZERO, D_POSITIVE, OF_I),
        term(NOT_ZERO, D_POSITIVE, D_POSITIVE, OF_I),
        term(NOT_ZERO, NOT_ZERO, D_POSITIVE, EQ_20),
    ),
    {LENGTH: (L + D) * _W.square + L**2 * D},
    (term(NOT_ZERO, NOT_ZERO, NOT_ZERO), term(NOT_ZERO, NOT_ZERO, D_POSITIVE)),
)
BOTH_OLD = Certificate((term(EQ_20),))


def _with_soft(certificate: Certificate, surplus: tuple[Term, ...]) -> Certificate:
    """Return the certificate for planes that are ε further away."""
    return Certificate((*certificate.terms, *surplus), certificate.equations, certificate.multiplier)


def vectors(d: Number, length: Number | None = None, **places: tuple[Number, Number, Number]) -> Vectors:
    """Return numbers for the variables: d̂_min, ‖n_ij‖ if it occurs, and positions by name; all in the same unit."""
    values = {
        f"{name}_{axis}": Fraction(x) for name, place in places.items() for axis, x in zip("xyz", place, strict=True)
    }
    values["d"] = Fraction(d)
    if length is not None:
        values["l"] = Fraction(length)
    return Vectors(values)


_ORIGIN = (0, 0, 0)
#: The old trajectories are half of d̂_min apart, so UAV i need keep only three quarters.
_HALFWAY_TOO_CLOSE = vectors(1, _HALF, i_old=_ORIGIN, j_old=(_HALF, 0, 0), i_new=(-_HALF / 2, 0, 0))
#: UAV j's planner believes UAV i beside UAV j, where it is not: both may go to the corner between the two planes.
_DIFFERENT_TRACKERS = Vectors(
    {
        **vectors(
            1, 2, i_old=_ORIGIN, j_old=(2, 0, 0), i_seen=(2, 2, 0), i_new=(_HALF, _HALF, 0), j_new=(_HALF, _HALF, 0)
        ).values,
        "l_seen": Fraction(2),
    }
)
_V = variable("v")
_ZERO = constant(0)
#: On the line through both, on the plane: ½(d̂_min + v) away from UAV j.
_ANY_DISTANCE = Candidate(
    {
        **{f"{name}_{axis}": _ZERO for name in ("i_old", "j_old", "i_new") for axis in "xyz"},
        "j_old_x": _V,
        "i_new_x": (_V - D) * _HALF,
        "l": _V,
    },
    (
        Certificate(),
        Certificate((term("v > 0"),)),
        Certificate(),
        Certificate(),
        # d² − (d + v)²/4 = (d − v)(3d + v)/4, and 3d + v = 3(d − v) + 4v
        Certificate((term("v < d", "v < d", factor=Fraction(3, 4)), term("v < d", "v > 0"))),
    ),
)
#: n² stands in for l²: n² = (20) + d².
_NOT_ZERO = Certificate(
    (*(term(squared=square) for square in _squares(_W)), term("l is not negative", D_POSITIVE, OF_I, factor=2)),
    {LENGTH: D**2},
    (term(EQ_20), term(D_POSITIVE, D_POSITIVE)),
)
_LITERAL = vectors(1, i_old=_ORIGIN, j_old=(1, 0, 0))


def _stated(cell: Cell) -> Evidence:
    """Return what is known of a cell of the table if only what its lemma states is assumed."""
    if cell.i.new and cell.j.new:
        return BOTH_NEW
    if cell.i.new:
        return _HALFWAY_TOO_CLOSE if cell.j.selected else ONE_NEW
    # the hypothesis of Lemma 4, or nothing at all
    return BOTH_OLD if cell.lemma else vectors(1, i_old=_ORIGIN, j_old=_ORIGIN)


def _with_20(cell: Cell) -> Evidence:
    """Return why a cell of the table is separated if (20) is true at the sample."""
    if cell.i.new:
        return BOTH_NEW if cell.j.new else (ONE_NEW_HALFWAY if cell.j.selected else ONE_NEW)
    return BOTH_OLD


_UNSELECTED, _SELECTED = "j is not in A_ET(k)", "j is in A_ET(k)"

EVIDENCE: Mapping[str, Mapping[str, Evidence]] = {
    "corollary-1/printed": {"both new": BOTH_NEW},
    "equal-trackers/printed": {"j's planner sees another trajectory of i": _DIFFERENT_TRACKERS},
    "equal-trackers/repaired": {"the same normals": BOTH_NEW},
    "equal-selection/printed": {
        "neither knows": vectors(1, 2, i_old=_ORIGIN, j_old=(2, 0, 0), i_new=(1, 0, 0), j_new=(1, 0, 0)),
        "one does not know": vectors(1, 3, i_old=_ORIGIN, j_old=(3, 0, 0), i_new=(1, 0, 0), j_new=(1, 0, 0)),
    },
    "equal-selection/repaired": {"both know": BOTH_NEW},
    "lemma-3/printed": {_UNSELECTED: ONE_NEW, _SELECTED: _HALFWAY_TOO_CLOSE},
    "lemma-3/repaired": {_UNSELECTED: ONE_NEW, _SELECTED: ONE_NEW_HALFWAY},
    "lemma-3-condition/repaired": {"any distance below d": _ANY_DISTANCE},
    "normal-not-zero/printed": {
        "n_ij may be zero": vectors(1, 0, i_old=_ORIGIN, j_old=_ORIGIN, i_new=_ORIGIN),
    },
    "normal-not-zero/repaired": {"(20) is true": _NOT_ZERO},
    "soft-constraint/printed": {
        "both new": _with_soft(BOTH_NEW, (term(D_POSITIVE, NOT_ZERO, NOT_ZERO, "epsilon >= 0", factor=4),)),
        _UNSELECTED: _with_soft(ONE_NEW, (term(D_POSITIVE, NOT_ZERO, NOT_ZERO, "epsilon >= 0", factor=2),)),
        _SELECTED: _with_soft(
            ONE_NEW_HALFWAY,
            (
                term(D_POSITIVE, NOT_ZERO, NOT_ZERO, NOT_ZERO, "epsilon >= 0", factor=2),
                term(D_POSITIVE, D_POSITIVE, NOT_ZERO, NOT_ZERO, "epsilon >= 0", factor=2),
            ),
        ),
    },
    "pairs/printed": {cell.id: _stated(cell) for cell in cells()},
    "pairs/repaired": {cell.id: _with_20(cell) for cell in cells()},
    "index-slips/printed": {
        "(18) can be met": Unsolvable({"d": Fraction(1)}, Certificate((term("(18)"),))),
        "(21)": _LITERAL,
    },
    "index-slips/repaired": {"(21)": BOTH_OLD},
    "theorem-2-strict/printed": {"(23)": _LITERAL},
    "theorem-2-strict/repaired": {"(23)": BOTH_OLD},
}
