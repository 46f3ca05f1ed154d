"""All trajectories that UAVs may be following, as the trackers say, and how close any two come at the samples.

Squared scaled distances are sums of three squares of exact integers, so float64 has them with a relative error below
4·2⁻⁵³ (7·2⁻⁵³ where pairs have units of their own). That orders them well enough to find a closest pair, whose distance
is then computed exactly. Where that is as close to d̂_min as that error, all pairs that may be the closest are computed
exactly.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from swarmproof.dmpc_swarm.claims.flight import Approach, PlannedBy
from swarmproof.dmpc_swarm.flight.state import FlightState, Name
from swarmproof.dmpc_swarm.planner.plan import Plan
from swarmproof.motion.lattice import Floats, Lattice
from swarmproof.motion.pairs import turned

Mask = NDArray[np.bool_]

#: Far more than the relative error of a squared distance in float64, far less than anything that matters.
_DOUBT = 2.0**-48


def tracked(state: FlightState) -> set[Name]:
    """Return the trajectories in all CUs' trackers that are not deprecated."""
    return {
        (i, trajectory.metadata)
        for cu in state.swarm.cus
        for i, tracker in enumerate(cu.trackers)
        if not tracker.deprecated
        for trajectory in tracker.trajectories
    }


class Candidates:
    """Some trajectories from the start of round k on, and the squared distances of any two at every sample.

    Attributes:
        names: whose they are and what they are called, sorted.
        owners: shape (n,).
        squares: in squares of the smallest unit of scaled distances, shape (n, n, H·m + 1).
    """

    def __init__(self, lattice: Lattice, k: int, named: Iterable[tuple[Name, Plan]]) -> None:
        self._lattice = lattice
        self._k = k
        items = sorted(named, key=lambda item: item[0])
        self.names = [name for name, _ in items]
        self.owners = np.array([i for i, _ in self.names])
        self._q = np.array([plan.scaled_from(k) for _, plan in items])
        owners = self.owners
        self._second = lattice.pairs.second(owners[:, None, None], owners[None, :, None])
        apart = turned(self._q[:, None] - self._q[None], self._second)
        self.squares: Floats = np.einsum("abhx,abhx->abh", apart, apart)
        weights = lattice.pairs.weights(owners[:, None, None], owners[None, :, None])
        if weights is not None:
            self.squares *= weights
        self._lowest = [self.squares.min(axis=2), self.squares[:, :, 1:].min(axis=2)]

    def have(self, names: Iterable[Name]) -> Mask:
        """Return which of the trajectories are among `names`."""
        wanted = set(names)
        return np.array([name in wanted for name in self.names])

    def pairs(self, some: Mask, others: Mask) -> Mask:
        """Return the pairs of one of `some` and one of `others`, of different UAVs. Shape (n, n)."""
        either = some[:, None] & others[None, :]
        pairs: Mask = (either | either.T) & (self.owners[:, None] != self.owners[None, :])
        return pairs

    def among(self, some: Iterable[Name], others: Iterable[Name], first: int = 1) -> Approach | None:
        """Return the closest approach of one of `some` and one of `others`, of different UAVs; see :meth:`closest`."""
        return self.closest(self.pairs(self.have(some), self.have(others)), first)

    def closest(self, pairs: Mask, first: int = 1) -> Approach | None:
        """Return the closest approach of these `pairs` at samples `first` (0 or 1) … h_c; None if there are none."""
        lowest = np.where(pairs, self._lowest[first], np.inf)
        at = int(lowest.argmin())
        smallest = float(lowest.flat[at])
        if smallest == np.inf:
            return None
        a, b = divmod(at, len(self.names))
        places = [(a, b, first + int(self.squares[a, b, first:].argmin()))]
        pairs_kept = self._lattice.pairs
        limit = float(pairs_kept.square(pairs_kept.distance))
        if abs(smallest - limit) <= _DOUBT * limit:
            near = (self.squares <= smallest * (1 + _DOUBT)) & pairs[:, :, None]
            near[:, :, :first] = False
            places = [(int(i), int(j), int(h)) for i, j, h in np.argwhere(near) if i < j]
        return min((self._approach(*place) for place in places), key=lambda approach: approach.square)

    def _approach(self, a: int, b: int, h: int) -> Approach:
        apart = turned(self._q[b, h] - self._q[a, h], None if self._second is None else self._second[a, b, 0])
        return _approach(self._lattice, self._k, (self.names[a], self.names[b]), apart, h)


def closest_at_samples(lattice: Lattice, k: int, names: Sequence[Name], positions: Floats) -> Approach | None:
    """Return the closest approach of references, called `names`, at the samples of round k.

    Args:
        lattice: the units.
        k: the round.
        names: of the trajectories, one for each UAV.
        positions: as :meth:`~swarmproof.dmpc_swarm.planner.plan.Plan.scaled_from` has them, shape (m, N, 3).
    """
    one, other = np.triu_indices(len(names), 1)
    if not len(one):
        return None
    pairs, owners = lattice.pairs, np.array([i for i, _ in names])
    apart = turned(positions[:, other] - positions[:, one], pairs.second(owners[one], owners[other]))
    squares = np.einsum("hpx,hpx->hp", apart, apart)
    weights = pairs.weights(owners[one], owners[other])
    if weights is not None:
        squares *= weights
    smallest = float(squares.min())
    limit = float(pairs.square(pairs.distance))
    # far from d̂_min, the pair whose computed distance is the smallest decides, and no other
    near = np.argwhere(squares <= smallest * (1 + (_DOUBT if abs(smallest - limit) <= _DOUBT * limit else 0)))
    return min(
        (_approach(lattice, k, (names[one[p]], names[other[p]]), apart[h, p], int(h)) for h, p in near),
        key=lambda approach: approach.square,
    )


def _approach(lattice: Lattice, k: int, names: tuple[Name, Name], apart: Floats, h: int) -> Approach:
    square = sum(int(x) ** 2 for x in apart) * lattice.pairs.unit_of(names[0][0], names[1][0]) ** 2
    time = k * lattice.parameters.T_s + h * lattice.parameters.T_c
    (i, one), (j, other) = names
    return Approach(square, (i, j), (PlannedBy(*one), PlannedBy(*other)), time)
