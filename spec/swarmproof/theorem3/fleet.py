"""Fleets of several kinds of UAVs: what a pair of different ones is bounded by.

Each kind has parameters of its own (bounds, distances, scaling), as if all UAVs were of that kind; times are common to
all. For two UAVs of kinds a and b, only sums of their bounds and radii matter to eqs. (15), (24) and (26). So their
pair is that of two equal UAVs with the *mean* of a and b in every bound and distance: the sum of their radii is
d̂_min.
The scaling of a pair of diagonal Θ⁻¹ is the smaller entry per axis: ‖Θ_ab⁻¹ x‖ ≤ ‖Θ_a⁻¹ x‖ and ‖Θ_b⁻¹ x‖, so the
ellipsoid of the pair contains both ellipsoids, laid against each other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

from swarmproof.errors import BadInput
from swarmproof.theorem3.numbers import near_match, shown
from swarmproof.theorem3.parameters import Parameters
from swarmproof.theorem3.values import NORMS, OF_A_KIND, Matrix, Vector, diagonal

MOST_KINDS = 64


class Kind(NamedTuple):
    """UAVs that are alike.

    Attributes:
        name: for people; unique in a fleet.
        uavs: their numbers; empty where no numbers are given, as in a margin without a mission.
        parameters: as if all UAVs were of this kind; d̂_min is what two of them keep.
    """

    name: str
    uavs: tuple[int, ...]
    parameters: Parameters


@dataclass(frozen=True)
class Fleet:
    """The parameters of every UAV of a swarm.

    Attributes:
        base: those of UAVs of no kind; times, the flying space and the units of distances are theirs for all.
        parameters: of each kind that some UAV is of.
        members: by UAV, its place among `parameters`; empty where all are alike, however many there are.
    """

    base: Parameters
    parameters: tuple[Parameters, ...]
    members: tuple[int, ...] = ()

    @classmethod
    def alike(cls, parameters: Parameters) -> Fleet:
        """Return the fleet of UAVs that are all alike."""
        return cls(parameters, (parameters,))

    @classmethod
    def of(cls, base: Parameters, kinds: Sequence[Kind], uavs: int) -> Fleet:
        """Return the fleet of so many UAVs, some of them of these `kinds`.

        Raises:
            BadInput: a kind lists a UAV that there is not, or none, or two kinds have no common scaling.
        """
        if not kinds:
            return cls.alike(base)
        by_uav = [base] * uavs
        for kind in kinds:
            if not kind.uavs:
                raise BadInput(f"[[kinds]]: no UAV is of kind {kind.name}: write a line such as uavs = [0, 3]")
            for uav in kind.uavs:
                if uav >= uavs:
                    raise BadInput(
                        f"[[kinds]]: {kind.name} lists UAV {uav}, but there are {uavs} UAVs, numbered 0 to {uavs - 1}"
                    )
                by_uav[uav] = kind.parameters
        distinct = tuple(dict.fromkeys(by_uav))
        fleet = cls(base, distinct, tuple(distinct.index(one) for one in by_uav))
        fleet.pair(0, 0)  # every pair is made now, so that what cannot be is said
        return fleet

    @cached_property
    def widest(self) -> Parameters:
        """Parameters of which d̂_min, with Θ, is enough for any two UAVs; the base's own where all are alike."""
        if not self.members:
            return self.base
        scaling, kept = self.parameters[0].theta_inverse, max(one.d_hat_min for one in self.parameters)
        for one in self.parameters[1:]:
            scaling = _common(scaling, one.theta_inverse)
        return replace(self.base, theta_inverse=scaling, d_hat_min=kept)

    def place(self, uav: int) -> int:
        """Return the place of a UAV's parameters."""
        return self.members[uav] if self.members else 0

    def of_uav(self, uav: int) -> Parameters:
        """Return the parameters of a UAV."""
        return self.parameters[self.place(uav)]

    def pair(self, one: int, other: int) -> Parameters:
        """Return the parameters of a pair of UAVs whose own are at these places, as :func:`pair` does."""
        return self._pairs[one][other]

    @cached_property
    def _pairs(self) -> list[list[Parameters]]:
        return [[pair(one, other) for other in self.parameters] for one in self.parameters]


class KindPair(NamedTuple):
    """Two kinds, which may be the same, and the parameters of one UAV of each as a pair of equal ones.

    `members` are the parameters of the two kinds.
    """

    names: tuple[str, str]
    parameters: Parameters
    members: tuple[Parameters, Parameters]

    @property
    def proportional(self) -> bool:
        """Say whether every motion of two equal UAVs is one of these two, shared in the ratio of their bounds.

        So it is if the bounds of each axis are in one ratio (with bounds of the norm: all bounds are in one), and no
        workspace confines them.
        """
        one, other = self.members
        if one == other:
            return True
        if one.workspace is not None:
            return False
        names = list(NORMS.items())[: self.parameters.order]
        norms = [(getattr(one, norm), getattr(other, norm)) for norm, _ in names]
        boxes = [[(getattr(one, box)[k], getattr(other, box)[k]) for _, box in names] for k in range(3)]
        if all(norm == (None, None) for norm in norms):
            return all(map(_in_one_ratio, boxes))
        return _in_one_ratio([*norms, *(bounds for axis in boxes for bounds in axis)])


def _in_one_ratio(bounds: Sequence[tuple[Fraction | None, Fraction | None]]) -> bool:
    """Say whether the bounds of two kinds, of which both or neither may be missing, have one ratio."""
    if any((one is None) != (other is None) for one, other in bounds):
        return False
    some = [(one, other) for one, other in bounds if one is not None and other is not None and (one or other)]
    return all(one * some[0][1] == other * some[0][0] for one, other in some)


def read_kinds(raw: object, base: Parameters) -> tuple[Kind, ...]:
    """Return the kinds in the list of tables `raw`, [[kinds]]; what a table does not give is that of `base`.

    Raises:
        BadInput: no list of tables, an unknown name, a value that cannot be, or a UAV of two kinds.
    """
    if not isinstance(raw, list) or not all(isinstance(table, Mapping) for table in raw):
        raise BadInput("kinds are tables: write a line [[kinds]], and lines such as uavs = [0, 3] and v_max = 2 below")
    if len(raw) > MOST_KINDS:
        raise BadInput(f"there are {len(raw)} kinds: {MOST_KINDS} are the most")
    kinds: list[Kind] = []
    for number, table in enumerate(raw):
        try:
            kinds.append(_kind(table, f"kind {number}", base))
        except BadInput as mistake:
            raise BadInput(f"the table {number + 1} of [[kinds]]: {mistake}") from None
    seen: dict[int, str] = {}
    for kind in kinds:
        for uav in kind.uavs:
            if uav in seen:
                raise BadInput(f"[[kinds]]: UAV {uav} is of two kinds, {seen[uav]} and {kind.name}: list it once")
            seen[uav] = kind.name
    if len({kind.name for kind in kinds}) < len(kinds):
        raise BadInput('[[kinds]]: two kinds have one name: give each its own, such as name = "large"')
    return tuple(kinds)


def _kind(table: Mapping[str, Any], name: str, base: Parameters) -> Kind:
    known = ("name", "uavs", *OF_A_KIND)
    for key in table:
        if key not in known:
            raise BadInput(f"there is no key {shown(key)} here: {near_match(key, known)}")
    name = table.get("name", name)
    if not isinstance(name, str) or not name.strip() or not name.isprintable() or len(name) > 40:
        raise BadInput('name must be a text of 1 to 40 characters on one line, such as name = "large"')
    uavs = table.get("uavs", [])
    if not isinstance(uavs, list) or not all(type(uav) is int and uav >= 0 for uav in uavs):
        raise BadInput("uavs must be a list of UAVs, numbered from 0, such as uavs = [0, 3]")
    values = {key: value for key, value in table.items() if key in OF_A_KIND}
    return Kind(name, tuple(uavs), base.with_table(name, values))


def pair(one: Parameters, other: Parameters) -> Parameters:
    """Return the parameters of a pair of UAVs, one of each kind, as if both were equal: what sums of theirs say.

    Raises:
        BadInput: two different scalings that are not both diagonal.
    """
    if one == other:
        return one
    half = Fraction(1, 2)
    return replace(
        one,
        v_max=_mean(one.v_max, other.v_max),
        a_max=_mean(one.a_max, other.a_max),
        j_max=_mean(one.j_max, other.j_max),
        v_norm=_mean_norm(one.v_norm, other.v_norm),
        a_norm=_mean_norm(one.a_norm, other.a_norm),
        j_norm=_mean_norm(one.j_norm, other.j_norm),
        d_hat_min=half * (one.d_hat_min + other.d_hat_min),
        d_min=half * (one.d_min + other.d_min),
        tracking_error=half * (one.tracking_error + other.tracking_error),
        theta_inverse=_common(one.theta_inverse, other.theta_inverse),
        crash_theta_inverse=None
        if one.crash_theta_inverse is None and other.crash_theta_inverse is None
        else _common(one.crash_theta_inverse or one.theta_inverse, other.crash_theta_inverse or other.theta_inverse),
    )


def pairs(kinds: Sequence[Kind]) -> list[KindPair]:
    """Return every pair of kinds; one of a kind with itself only if it has two UAVs, or no numbers are given."""
    return [
        KindPair((one.name, other.name), pair(one.parameters, other.parameters), (one.parameters, other.parameters))
        for one, other in combinations_with_replacement(kinds, 2)
        if one is not other or len(one.uavs) != 1
    ]


def _mean(one: Vector, other: Vector) -> Vector:
    x, y, z = ((a + b) / 2 for a, b in zip(one, other, strict=True))
    return (x, y, z)


def _mean_norm(one: Fraction | None, other: Fraction | None) -> Fraction | None:
    return None if one is None or other is None else (one + other) / 2


def _common(one: Matrix, other: Matrix) -> Matrix:
    """Return a scaling in which nothing is longer than in `one` and in `other`."""
    if one == other:
        return one
    for matrix in (one, other):
        if matrix != diagonal(_diagonal(matrix)):
            raise BadInput(
                "kinds with different theta_inverse must have diagonal ones, such as theta_inverse = [1, 1, 0.5]"
            )
    x, y, z = map(min, _diagonal(one), _diagonal(other))
    return diagonal((x, y, z))


def _diagonal(matrix: Matrix) -> Vector:
    return (matrix[0][0], matrix[1][1], matrix[2][2])
