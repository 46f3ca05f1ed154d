"""Certified separation between the samples: how close UAVs on piecewise cubics come, at any time of a step T_c.

Over a step every coordinate of a scaled position q is a cubic, so the squared distance |q_j − q_i|² of a pair is a
polynomial of degree 6. Its Bernstein coefficients bound it from below; the first and the last are its values at the
ends. Branch and bound closes the gap: a part of a step whose bound does not matter any more is done with, the others
are split where the control polygon of the derivative crosses zero, which approaches a minimum as fast as Newton does.

The cubics come as `pieces`, shape (steps, UAVs, 3 axes, 4): the Bernstein coefficients of q over each step, integers
(units of :mod:`swarmproof.motion.lattice`) of at most 2⁵⁰ in absolute value. All squares are in units of |q|².

Rounding, with u = 2⁻⁵³ and γ_n = nu / (1 − nu). What follows holds for sums in any order, with fused operations or not.

- The coefficients d_k of a pair's difference are integers of at most 2⁵¹: exact.
- Let D be the largest |d_k|². A coefficient c_k = Σ w_kij d_i·d_j has weights w ≥ 0 of sum 1. It is computed as a sum
  of ten products of a rounded weight and a d_i·d_j, itself three products: |ĉ_k − c_k| ≤ γ_14 D (Cauchy, Schwarz). The
  computed D, called M below, is at least (1 − γ_3) D, hence |ĉ_k − c_k| ≤ 15uM.
- A split is six rows of affine steps a(1 − t) + bt. As t is a multiple of 2⁻⁵² in [0, 1], 1 − t is exact, and a step
  is wrong by at most γ_2 max(|a|, |b|). Exact steps enlarge neither numbers nor errors: n splits add at most 13nuM.
- Subtracting or adding the slack below errs by less than 2uM, and all underflow in sum by far less than uM: M is at
  least 1, unless all is 0 and exact.

- Where pairs have weights of at least 1, M and all c are multiplied with the rounded one: 3uM more.

So after n splits a coefficient less a slack of (24 + 16n)uM is a lower bound, and one at an end plus it an upper one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import pairwise
from math import comb, inf, nextafter

import numpy as np
from numpy.typing import NDArray

from swarmproof.errors import BadInput
from swarmproof.motion.pairs import Scales

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

#: No coefficient may be larger: differences and sums of them would not be exact.
LARGEST = 2.0**50
#: The slack above in units of uM: before any split, and for each.
ROUNDING, ROUNDING_OF_SPLIT = 24, 16
_U = 2.0**-53
#: How wide an enclosure may be, relative to its upper end: the one of the closest approach, and those in a plot.
WIDTH, WIDTH_OF_STEP = 1e-9, 1e-6
#: How often a part is split at most. From the 24th split on, parts are halved.
DEPTH, HALVED_FROM = 52, 24
#: The same for a plot, where a band may be wider.
DEPTH_OF_STEP = 12
#: How often a part is halved in exact arithmetic before a question stays open.
EXACT_DEPTH = 64
#: How many pieces (a pair in a step) are looked at together: as many as fit into a cache.
_TOGETHER = 4096

# the products d_i·d_j, and sixty times the weight that each one has in each coefficient of degree 6: integers
_FACTORS = [(i, j) for i in range(4) for j in range(i, 4)]
_WEIGHTS = [
    [(60 if i == j else 120) * comb(3, i) * comb(3, j) // comb(6, k) if i + j == k else 0 for i, j in _FACTORS]
    for k in range(7)
]
_ROUNDED_WEIGHTS = np.array(_WEIGHTS, float) / 60
_FIRST, _SECOND = np.array(_FACTORS).T
_SQUARES = np.flatnonzero(_FIRST == _SECOND)


@dataclass(frozen=True, slots=True)
class Closest:
    """The closest approach of any two UAVs: lower ≤ min |q_j − q_i|² ≤ upper, in units of |q|²; both are certified.

    Attributes:
        lower: a lower bound of the exact minimum over all times and pairs.
        upper: the exact value at the place below, rounded up.
        step: index of the step.
        pair: indices (i, j) of the UAVs, i < j.
        fraction: where in the step, 0 … 1.
    """

    lower: float
    upper: float
    step: int
    pair: tuple[int, int]
    fraction: float


def cubics(states: Floats, jerks: Floats, scaling: Floats, steps: int) -> Floats:
    """Return the pieces of one period, shape (`steps`, U, 3, 4), exactly.

    Args:
        states: of U UAVs at the start of the period, shape (U, 3, 3): rows position, velocity, acceleration.
        jerks: of the period, shape (U, 3).
        scaling: S = L·Θ⁻¹, integers, shape (3, 3).
        steps: how many steps T_c the period has.
    """
    p, v, a = states[:, 0], states[:, 1], states[:, 2]
    pieces = np.empty((steps, len(states), 3, 4))
    for step in pieces:
        end = p + 3 * v + 3 * a + jerks
        for k, corner in enumerate((p, p + v, p + 2 * v + a, end)):
            step[:, :, k] = corner @ scaling.T
        p, v, a = end, v + 2 * a + jerks, a + jerks
    return pieces


def closest(pieces: Floats, second: Scales | None = None) -> Closest:
    """Return the closest approach over all `pieces`, shape (R, U, 3, 4), and all pairs of their UAVs.

    The enclosure is not wider than :data:`WIDTH` · upper + 1e-12 M, M being the largest |d_k|² of any pair and step.
    The second part shows only where UAVs nearly meet, and is usually much smaller.

    Args:
        pieces: of q, or of positions where `second` is given.
        second: how the differences of the pairs i < j, in the order of their indices, are scaled, and what squares of
            them are worth (:meth:`swarmproof.motion.pairs.Pairs.among`): all squares are meant times these weights.

    Raises:
        BadInput: `pieces` has another shape, no step, less than two UAVs, or a number that is no integer up to 2⁵⁰,
            less if `second` makes it larger.
    """
    # The second part: 856uM of slack count up to four times. Parts that are open after 52 splits are h = 2⁻²⁸ long, and
    # second differences of c at most 4h²M: a coefficient is within 3h²M of a value, a minimum within 15h²M of one at an
    # end, together 3uM. And `fraction` is wrong by at most 3u for each split, hence the value there by 52 · 3u · 12M.
    found = _Search(_checked(pieces, second), second, None)
    step, i, j = _place(pieces, found.piece)
    square = _square_at(_difference(pieces, second, found.piece), found.fraction)
    upper = _rounded_up(square * _weight(second, found.piece))
    return Closest(min(found.lower, upper), upper, step, (i, j), found.fraction)


def at_least(pieces: Floats, square: Fraction, second: Scales | None = None) -> bool | None:
    """Return whether |q_j − q_i|² ≥ `square` for all pairs and times of `pieces`, shape (R, U, 3, 4).

    True is certified; False means that a place with a smaller value is known, exactly. None: the minimum is so close to
    `square` that even :data:`EXACT_DEPTH` halvings in exact arithmetic do not tell, such as when it equals it at 1/3.

    Raises:
        BadInput: as :func:`closest`.
    """
    found = _Search(_checked(pieces, second), second, _rounded_up(square))
    if _square_at(_difference(pieces, second, found.piece), found.fraction) * _weight(second, found.piece) < square:
        return False
    answers = {
        _exactly_at_least(_difference(pieces, second, piece), square / _weight(second, piece)) for piece in found.unsure
    }
    return False if False in answers else None if None in answers else True


def lowest_per_step(pieces: Floats, second: Scales | None = None) -> tuple[Floats, Floats]:
    """Return certified bounds (lower, upper), shape (R,) each, of the smallest |q_j − q_i|² of all pairs in each step.

    They are :data:`WIDTH_OF_STEP` · upper apart, or more where :data:`DEPTH_OF_STEP` splits do not reach that.

    Raises:
        BadInput: as :func:`closest`.
    """
    lower, upper = np.full(len(pieces), inf), np.full(len(pieces), inf)
    pairs = len(_pairs(_checked(pieces, second).shape[1])[0])
    for boxes in _whole_steps(pieces, second):
        while True:
            step = boxes.pieces // pairs
            np.minimum.at(upper, step, boxes.upper)
            is_open = boxes.reaches_below((1 - WIDTH_OF_STEP) * upper[step]) & (boxes.depth < DEPTH_OF_STEP)
            np.minimum.at(lower, step[~is_open], boxes.lower[~is_open])
            if not is_open.any():
                break
            boxes = boxes.only(is_open).split()
    return lower, upper


@dataclass(frozen=True, slots=True)
class _Boxes:
    """Parts of pieces, all of them the result of `depth` splits.

    Attributes:
        rows: shape (11, n), a column a part: the seven Bernstein coefficients of the squared distance on it; M of the
            whole piece; the piece, step · pairs + pair; where in the step the part begins and ends, but for rounding.
    """

    rows: Floats
    depth: int

    @property
    def pieces(self) -> Integers:
        """The piece of each part."""
        pieces: Integers = self.rows[8].astype(np.int64)
        return pieces

    @property
    def slack(self) -> Floats:
        """How wrong the coefficients of each part can be: the bound at the top of this module."""
        slack: Floats = self.rows[7] * ((ROUNDING + ROUNDING_OF_SPLIT * self.depth) * _U)
        return slack

    @property
    def lower(self) -> Floats:
        """A lower bound for each part."""
        lower: Floats = np.maximum(self.rows[:7].min(axis=0) - self.slack, 0)
        return lower

    @property
    def upper(self) -> Floats:
        """An upper bound for the smaller one of the values at the ends of each part."""
        upper: Floats = np.minimum(self.rows[0], self.rows[6]) + self.slack
        return upper

    def reaches_below(self, goal: Floats | float) -> Mask:
        """Return which parts have a lower bound below `goal` for which rounding alone is no reason."""
        reaches: Mask = self.rows[:7].min(axis=0) + self.slack < goal
        return reaches

    def only(self, which: Mask) -> _Boxes:
        """Return the parts selected."""
        return _Boxes(self.rows[:, which], self.depth)

    def split(self) -> _Boxes:
        """Return two parts for each one (de Casteljau)."""
        row = self.rows[:7]
        t = np.full(row.shape[1], 0.5) if self.depth >= HALVED_FROM else _splitting_points(row)
        rest = 1 - t
        left, right = self.rows.copy(), self.rows.copy()
        for k in range(1, 7):
            row = row[:-1] * rest + row[1:] * t
            left[k], right[6 - k] = row[0], row[-1]
        left[10] = right[9] = self.rows[9] + t * (self.rows[10] - self.rows[9])
        return _Boxes(np.concatenate([left, right], axis=1), self.depth + 1)


def _splitting_points(squares: Floats) -> Floats:
    """Return where to split parts (0 … 1 of each, multiples of 2⁻⁵²): any choice is sound, this one is fast."""
    k = np.clip(squares.argmin(axis=0), 1, 5)
    part = np.arange(squares.shape[1])
    # the derivative's coefficients k − 1 and k are −before and after, but for a factor, and stand at (k − 1)/5 and k/5
    before = squares[k - 1, part] - squares[k, part]
    after = squares[k + 1, part] - squares[k, part]
    t = (k - 1 + before / np.maximum(before + after, 1e-300)) / 5
    t = np.rint(t * 2.0**52) * 2.0**-52
    return np.where((t > 0) & (t < 1), t, 0.5)


class _Search:
    """Branch and bound over all pieces: for the minimum or, if there is a goal, until it is clear which one is below.

    Attributes:
        lower: a lower bound of the minimum.
        best: the smallest upper bound found.
        piece: the piece of that.
        fraction: where in its step, but for rounding.
        unsure: pieces with a part whose lower bound remained below the goal.
    """

    def __init__(self, pieces: Floats, second: Scales | None, goal: float | None) -> None:
        self.lower = self.best = inf
        self.piece, self.fraction = 0, 0.0
        self.unsure: set[int] = set()
        self._goal = goal
        waiting = [self._open(some).rows for some in _whole_steps(pieces, second)]
        boxes = self._open(_Boxes(np.concatenate(waiting, axis=1), 0))
        while boxes.rows.size and boxes.depth < DEPTH and not (goal is not None and self.best < goal):
            boxes = self._open(boxes.split())
        self._done_with(boxes)

    def _open(self, boxes: _Boxes) -> _Boxes:
        """Return the parts worth a split; the others are done with."""
        if not boxes.rows.size:
            return boxes
        upper = boxes.upper
        part = int(upper.argmin())
        if upper[part] < self.best:
            self.best = float(upper[part])
            first, *_, last, _, piece, begin, end = boxes.rows[:, part].tolist()
            self.piece, self.fraction = int(piece), begin if first <= last else end
        is_open = boxes.reaches_below((1 - WIDTH) * self.best if self._goal is None else self._goal)
        self._done_with(boxes.only(~is_open))
        return boxes.only(is_open)

    def _done_with(self, boxes: _Boxes) -> None:
        lower = boxes.lower
        self.lower = min(self.lower, float(lower.min(initial=inf)))
        if self._goal is not None:
            self.unsure.update(boxes.pieces[lower < self._goal].tolist())


def _whole_steps(pieces: Floats, second: Scales | None) -> Iterator[_Boxes]:
    """Yield every piece as a part of its own, some steps at a time."""
    one, other = _pairs(pieces.shape[1])
    by_axis = np.ascontiguousarray(pieces.transpose(2, 3, 0, 1))
    at_once = max(1, _TOGETHER // len(one))
    weights = None if second is None else np.array([float(weight) for weight in second.weights])
    for begin in range(0, len(pieces), at_once):
        some = by_axis[:, :, begin : begin + at_once]
        apart = some[..., other] - some[..., one]
        if second is not None:
            apart = np.einsum("pxy,yksp->xksp", second.matrices, apart)
        d = apart.reshape(3, 4, -1)
        products = (d[:, _FIRST] * d[:, _SECOND]).sum(axis=0)
        rows = np.zeros((11, products.shape[1]))
        rows[:7] = _ROUNDED_WEIGHTS @ products
        rows[7] = products[_SQUARES].max(axis=0)
        if weights is not None:
            rows[:8] *= np.tile(weights, products.shape[1] // len(one))
        rows[8] = begin * len(one) + np.arange(products.shape[1])
        rows[10] = 1
        yield _Boxes(rows, 0)


@cache
def _pairs(uavs: int) -> tuple[Integers, Integers]:
    first, second = np.triu_indices(uavs, 1)
    return first, second


def _place(pieces: Floats, piece: int) -> tuple[int, int, int]:
    """Return the step and the two UAVs of a piece."""
    first, second = _pairs(pieces.shape[1])
    step, pair = divmod(piece, len(first))
    return step, int(first[pair]), int(second[pair])


def _difference(pieces: Floats, second: Scales | None, piece: int) -> list[list[int]]:
    """Return the coefficients of q_j − q_i over a piece, exactly: four for each axis."""
    step, i, j = _place(pieces, piece)
    apart = pieces[step, j] - pieces[step, i]
    if second is not None:
        apart = second.matrices[piece % len(second.matrices)] @ apart
    return [[int(d) for d in axis] for axis in apart.tolist()]


def _weight(second: Scales | None, piece: int) -> Fraction:
    """Return what a square of a piece's pair is worth."""
    return Fraction(1) if second is None else second.weights[piece % len(second.weights)]


def _square_at(difference: list[list[int]], fraction: float) -> Fraction:
    """Return the squared length of the cubic `difference` at a `fraction` of the step, exactly."""
    part, whole = fraction.as_integer_ratio()
    rest = whole - part
    weights = (rest**3, 3 * rest * rest * part, 3 * rest * part * part, part**3)
    return Fraction(sum(sum(w * d for w, d in zip(weights, axis, strict=True)) ** 2 for axis in difference), whole**6)


def _exactly_at_least(difference: list[list[int]], square: Fraction) -> bool | None:
    """Return whether |`difference`|² ≥ `square` over the step, by integers alone; None if the halvings do not tell."""
    products = [sum(axis[i] * axis[j] for axis in difference) for i, j in _FACTORS]
    # only signs matter: all is multiplied by 60 and by the denominator, and by 2⁶ in each halving
    excess = [
        square.denominator * sum(w * d for w, d in zip(weights, products, strict=True)) - 60 * square.numerator
        for weights in _WEIGHTS
    ]
    waiting, told = [(excess, 0)], True
    while waiting:
        excess, depth = waiting.pop()
        if excess[0] < 0 or excess[6] < 0:
            return False
        if min(excess) >= 0:
            continue
        if depth == EXACT_DEPTH:
            told = False
            continue
        left, right = [], []
        for shift in range(6, -1, -1):
            left.append(excess[0] << shift)
            right.append(excess[-1] << shift)
            excess = [a + b for a, b in pairwise(excess)]
        waiting += [(left, depth + 1), (right[::-1], depth + 1)]
    return True if told else None


def _rounded_up(value: Fraction) -> float:
    nearest = float(value)
    return nearest if Fraction(nearest) >= value else nextafter(nearest, inf)


def _checked(pieces: Floats, second: Scales | None) -> Floats:
    """Return `pieces`; raise :class:`BadInput` unless they are what this module is sound for."""
    if pieces.ndim != 4 or pieces.shape[2:] != (3, 4) or pieces.shape[0] < 1 or pieces.shape[1] < 2:
        raise BadInput(
            f"pieces of shape {pieces.shape} have no distances: "
            "(steps, UAVs, 3, 4), with at least one step and two UAVs, would be right"
        )
    stretched = 1.0 if second is None else float(np.abs(second.matrices).sum(axis=2).max())
    if not (np.abs(pieces).max() * stretched <= LARGEST and (pieces == np.rint(pieces)).all()):
        raise BadInput("pieces have a coefficient that is no integer of at most 2^50: lattice units would be right")
    return pieces
