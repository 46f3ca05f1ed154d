"""What is flown: the swarm's parameters, the weights of its cost, starts and targets; checked when it is made."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from itertools import combinations
from math import isfinite, sqrt

from swarmproof.errors import BadInput
from swarmproof.scenario.choices import MOST_ROUNDS, USUAL, Choices, changed
from swarmproof.scenario.points import Point, closest_pair, draw, moved_box, moved_points, scaling
from swarmproof.theorem3.fleet import Fleet, Kind
from swarmproof.theorem3.numbers import exact_text
from swarmproof.theorem3.parameters import Parameters
from swarmproof.theorem3.values import ClosedBox, Vector, closed

FEWEST_UAVS, MOST_UAVS = 2, 64
SHORTEST_HORIZON, LONGEST_HORIZON = 2, 60
DEFAULT_HORIZON = 15
#: How many collision samples one period may have, and how large L may be, the least common denominator of Θ⁻¹.
MOST_SAMPLES = 10
MOST_DENOMINATOR = 1000
#: m; where the flying space has no limit, its wall is further away than any coordinate can be.
FAR = Fraction(3 * 10**7)


@dataclass(frozen=True, slots=True)
class Weights:
    """The weights of the cost (13a) and of Appendix B's soft constraint; the defaults are the published ones.

    Raises:
        BadInput: a weight is negative or not finite, or `position` or `jerk` is 0: the optimum would not be unique.
    """

    position: float = 1.0
    speed: float = 1e-4
    acceleration: float = 5e-3
    jerk: float = 1e-3
    #: of the soft constraint
    band: float = 0.5
    #: m
    band_width: float = 0.3

    def __post_init__(self) -> None:
        """Raise :class:`BadInput` on a weight that cannot be."""
        for name in WEIGHTS:
            value = getattr(self, name)
            if not isfinite(value) or value < 0:
                raise BadInput(f"the weight {name} must be 0 or a positive number, not {value}")
            if value == 0 and name in ("position", "jerk"):
                raise BadInput(f"the weight {name} must be positive, not 0")


#: The names of the weights.
WEIGHTS: tuple[str, ...] = tuple(one.name for one in fields(Weights))


@dataclass(frozen=True, slots=True)
class Tolerance:
    """A fault: by how much plans may violate rows of (13f), in m of scaled distance; by nothing unless asked for.

    Attributes:
        full: rows of (15) with d̂_min alone, for a UAV that is not in A_ET(k).
        halfway: the other rows.

    Raises:
        BadInput: one of them is negative.
    """

    full: Fraction = Fraction(0)
    halfway: Fraction = Fraction(0)

    def __post_init__(self) -> None:
        """Raise :class:`BadInput` on a negative number."""
        for name, value in (("tolerance", self.full), ("tolerance_halfway", self.halfway)):
            if value < 0:
                raise BadInput(f"{name} must not be negative, but it is {exact_text(value)}")

    def asked(self, d_hat_min: Fraction, halfway: bool) -> Fraction:
        """Return the distance (m) with which a row without tolerance says what this one says with it."""
        return d_hat_min - (2 * self.halfway if halfway else self.full)

    def kept(self, d_hat_min: Fraction) -> Fraction:
        """Return the distance (m) that trajectories keep at samples, after however many rounds."""
        return min(self.asked(d_hat_min, halfway) for halfway in (True, False))


EXACT = Tolerance()

#: Who has which target: as listed, or by a random permutation for each change of the targets.
ASSIGNMENTS = ("listed", "shuffled")


#: How the swarm begins, and is sent on: d̂_min apart, as Remark 2 asks, or anyhow within the flying space.
BEGINNINGS = ("apart", "anyhow")

STILL: Vector = (Fraction(0), Fraction(0), Fraction(0))


@dataclass(frozen=True, slots=True)
class TargetChange:
    """From `round` on, `points[i]` (m) is the target of UAV i, and then moves on with `velocity` (m/s), if it does."""

    round: int
    points: tuple[Point, ...]
    velocity: Vector = STILL


@dataclass(frozen=True, slots=True)
class Redraw:
    """Every `every` rounds, new random targets, `separation` (m, scaled) or more apart."""

    every: int
    separation: Fraction
    seed: int


@dataclass(frozen=True, slots=True)
class Scenario:
    """What is flown.

    Attributes:
        horizon: H, in periods T.
        starts: where UAV i hovers at first (m; Remark 2).
        targets: the changes of the targets; if `redraw` is given, it goes on after the last of them.
        rounds: the length of a flight where no other is asked for.
        tolerance: of the rows of (13f) in plans: none, unless this fault is to be flown.
        choices: what the planner does where the paper is silent.
        jitter: m; by how much, at most and per axis, `starts` are disturbed already.
        assignment: one of :data:`ASSIGNMENTS`: whose targets the `targets` are already.
        hold: rounds between changes of the targets, if these are not the rounds that the scenario gave them.
        begin: one of :data:`BEGINNINGS`.
        repeat: rounds after which the targets begin anew; None if they do not.
        kinds: of UAVs with parameters of their own; the others have `parameters`.

    Raises:
        BadInput: a value that cannot be flown, such as two starts closer than d̂_min.
    """

    name: str
    parameters: Parameters
    horizon: int
    weights: Weights
    starts: tuple[Point, ...]
    targets: tuple[TargetChange, ...]
    rounds: int
    redraw: Redraw | None = None
    tolerance: Tolerance = EXACT
    choices: Choices = USUAL
    jitter: Fraction = Fraction(0)
    assignment: str = ASSIGNMENTS[0]
    hold: int | None = None
    begin: str = BEGINNINGS[0]
    repeat: int | None = None
    kinds: tuple[Kind, ...] = ()
    #: the random targets so far, by round: whatever is asked for first, the answers are the same
    _drawn: dict[int, tuple[Point, ...]] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Raise :class:`BadInput` on a value that cannot be flown."""
        for what, value, low, high in (
            ("horizon", self.horizon, SHORTEST_HORIZON, LONGEST_HORIZON),
            ("rounds", self.rounds, 1, MOST_ROUNDS),
            ("the number of UAVs", self.uavs, FEWEST_UAVS, MOST_UAVS),
        ):
            if not low <= value <= high:
                raise BadInput(f"{what} must be from {low} to {high}, not {value}")
        space = flying_space(self.parameters)
        d_hat_min = self.parameters.d_hat_min
        if self.tolerance.kept(d_hat_min) <= 0:
            raise BadInput(
                f"tolerance={exact_text(self.tolerance.full)} and tolerance_halfway="
                f"{exact_text(self.tolerance.halfway)} leave nothing of d_hat_min={exact_text(d_hat_min)}: the first "
                "must be smaller than it, the second smaller than half of it"
            )
        if not self.targets or self.targets[0].round != 0:
            raise BadInput(
                "there are no targets from round 0 on: the first of the targets must have round = 0, so write round = 0"
            )
        for earlier, later in zip(self.targets, self.targets[1:], strict=False):
            if later.round <= earlier.round:
                raise BadInput(
                    f"the targets of round {later.round} come after those of round {earlier.round}: sort them"
                )
        fleet = self.fleet
        after_jitter = " after jitter" if self.jitter else ""
        check_within("start", after_jitter, self.starts, space)
        if self.begin == BEGINNINGS[0]:
            check_apart("start", after_jitter, self.starts, fleet)
        for c, change in enumerate(self.targets):
            if len(change.points) != self.uavs:
                raise BadInput(
                    f"there are {self.uavs} starts, but {len(change.points)} targets from round {change.round} on: "
                    "give one target for each UAV"
                )
            check_within("target", f" from round {change.round} on", change.points, space)
            if self.begin == BEGINNINGS[0]:
                check_apart("target", f" from round {change.round} on", change.points, fleet)
            if change.velocity != STILL:
                last = max(self._last_round_of(c), change.round)
                check_within("target", f" in round {last}", self._moved_on(change, last), space)
        if self.repeat is not None and (self.redraw or self.repeat <= self.targets[-1].round):
            raise BadInput(
                f"repeat={self.repeat} must be more than the round {self.targets[-1].round} of the last targets, which "
                "must not be random ones with every"
            )
        if self.redraw:
            check_separation(self.redraw.separation, fleet.widest)

    @property
    def begins_too_close(self) -> str:
        """Which UAVs start closer than their d̂_min, in words; empty if none do (Remark 2)."""
        square, i, j, needed = _closest_of(self.starts, self.fleet)
        if square >= needed**2:
            return ""
        distance = _text(sqrt(square), needed, "less")
        return f"UAV {i} and UAV {j} start {distance} m apart, less than d_hat_min={exact_text(needed)} m"

    @property
    def uavs(self) -> int:
        """N."""
        return len(self.starts)

    @property
    def fleet(self) -> Fleet:
        """The parameters of every UAV."""
        return Fleet.of(self.parameters, self.kinds, self.uavs)

    def moved(self, by: Vector) -> Scenario:
        """Return the scenario with all points moved `by` so much (m), exactly; random ones, too, by whole metres."""
        if not any(by):
            return self

        def elsewhere(parameters: Parameters) -> Parameters:
            space = parameters.workspace
            return replace(parameters, workspace=None if space is None else moved_box(space, by))

        return replace(
            self,
            parameters=elsewhere(self.parameters),
            kinds=tuple(kind._replace(parameters=elsewhere(kind.parameters)) for kind in self.kinds),
            starts=moved_points(self.starts, by),
            targets=tuple(replace(change, points=moved_points(change.points, by)) for change in self.targets),
        )

    def differences(self) -> list[str]:
        """Return ``NAME=VALUE`` for all that is not as published, or not as listed, or not the usual choice.

        Starts, targets and the number of UAVs are what the scenario's name stands for.
        """
        texts = [*self.parameters.differences(), *changed(WEIGHTS, self.weights, Weights())]
        if self.horizon != DEFAULT_HORIZON:
            texts.append(f"horizon={self.horizon}")
        if self.tolerance != EXACT:
            texts.append(f"tolerance={exact_text(self.tolerance.full)}")
            texts.append(f"tolerance_halfway={exact_text(self.tolerance.halfway)}")
        if self.jitter:
            texts.append(f"jitter={exact_text(self.jitter)}")
        if self.assignment != ASSIGNMENTS[0]:
            texts.append(f"assignment={self.assignment}")
        if self.hold is not None:
            texts.append(f"hold={self.hold}")
        if self.begin != BEGINNINGS[0]:
            texts.append(f"begin={self.begin}")
        if self.repeat is not None:
            texts.append(f"repeat={self.repeat}")
        return [*texts, *self.choices.differences()]

    def targets_at(self, k: int) -> tuple[Point, ...]:
        """Return the target of every UAV in round k >= 0 (m).

        Raises:
            BadInput: new random targets were not found (see :func:`swarmproof.scenario.points.draw`).
        """
        change = self.target_change_before(k)
        if not self.redraw or change <= self.targets[-1].round:
            within = k if self.repeat is None else k % self.repeat
            return self._moved_on(self.targets[bisect_right(self.targets, within, key=_round) - 1], within)
        if change not in self._drawn:
            redraw, parameters = self.redraw, self.fleet.widest
            self._drawn[change] = draw(
                flying_space(parameters),
                parameters.theta_inverse,
                self.uavs,
                redraw.separation,
                redraw.seed,
                label(change),
            )
        return self._drawn[change]

    def target_change_before(self, k: int) -> int:
        """Return the last round <= k in which the targets changed; for k >= 0. Moving targets do in every round."""
        last = self.targets[-1].round
        if self.redraw and k > last:
            return k - (k - last) % self.redraw.every
        within = k if self.repeat is None else k % self.repeat
        change = self.targets[bisect_right(self.targets, within, key=_round) - 1]
        return k if change.velocity != STILL else k - within + change.round

    def _moved_on(self, change: TargetChange, k: int) -> tuple[Point, ...]:
        """Return where the targets of a `change` are in round k, not before it."""
        if change.velocity == STILL:
            return change.points
        x, y, z = (speed * self.parameters.T_s * (k - change.round) for speed in change.velocity)
        return moved_points(change.points, (x, y, z))

    def _last_round_of(self, c: int) -> int:
        """Return the last round in which the change number `c` holds."""
        if c + 1 < len(self.targets):
            return self.targets[c + 1].round - 1
        return self.rounds - 1 if self.repeat is None else self.repeat - 1


def flying_space(parameters: Parameters) -> ClosedBox:
    """Return the flying space (m: low and high per axis) of `parameters` with which one can fly.

    Raises:
        BadInput: there is no flying space, or the planner's problem (13) and the exact motion make no sense.
    """
    if parameters.order != 3:
        raise BadInput("order must be 3: a flight plans jerks")
    if parameters.T_b != parameters.T_s:
        raise BadInput(f"T_b={exact_text(parameters.T_b)} must equal T_s={exact_text(parameters.T_s)}, one period")
    if parameters.delay:
        raise BadInput(
            f"delay={exact_text(parameters.delay)} says nothing of a flight, in which what arrives is never late: "
            "leave it out (delay = 0), and ask swarmproof margin --set delay=0.02 what it costs"
        )
    samples = parameters.T_s / parameters.T_c
    if samples.denominator != 1 or samples > MOST_SAMPLES:
        raise BadInput(
            f"T_s must be 1 to {MOST_SAMPLES} times T_c, a whole number: "
            f"T_s={exact_text(parameters.T_s)} is {exact_text(samples)} times T_c={exact_text(parameters.T_c)}"
        )
    _, denominator = scaling(parameters.theta_inverse)
    if denominator > MOST_DENOMINATOR:
        raise BadInput(
            f"theta_inverse has the least common denominator {denominator}: "
            f"simpler fractions are needed, with at most {MOST_DENOMINATOR}"
        )
    if parameters.workspace is None:
        raise BadInput("the flying space is missing: give workspace, low and high of x, y and z in m")
    return closed(parameters.workspace, FAR)


def label(round_: int) -> str:
    """Return what is drawn for the targets from `round_` on, as :func:`swarmproof.scenario.points.draw` wants it."""
    return f"targets {round_}"


def check_separation(separation: Fraction, parameters: Parameters) -> None:
    """Raise :class:`BadInput` if random points with this separation (m, scaled) may be closer than d̂_min."""
    if separation < parameters.d_hat_min:
        raise BadInput(
            f"separation={exact_text(separation)} must be at least d_hat_min={exact_text(parameters.d_hat_min)}"
        )


def _round(change: TargetChange) -> int:
    return change.round


def check_within(what: str, when: str, points: Sequence[Point], space: ClosedBox) -> None:
    """Raise :class:`BadInput` unless the points, `what` `when`, are in the flying space."""
    for i, point in enumerate(points):
        for axis, value, (low, high) in zip("xyz", point, space, strict=True):
            if not low <= value <= high:
                shown = _text(value, low, "less") if value < low else _text(value, high, "more")
                raise BadInput(
                    f"the {what} of UAV {i}{when} is outside the flying space: "
                    f"{axis}={shown} is not in {exact_text(low)}…{exact_text(high)}"
                )


def check_apart(what: str, when: str, points: Sequence[Point], fleet: Fleet) -> None:
    """Raise :class:`BadInput` unless the points, `what` `when`, are as far apart as d̂_min of each two UAVs asks."""
    square, i, j, needed = _closest_of(points, fleet)
    if square < needed**2:
        distance = _text(sqrt(square), needed, "less")
        anyhow = ', or begin = "anyhow" to see what becomes of it'
        raise BadInput(
            f"the {what}s of UAV {i} and UAV {j}{when} are too close: their scaled distance is {distance} m, "
            f"but d_hat_min={exact_text(needed)} m is needed{anyhow}"
        )


def _closest_of(points: Sequence[Point], fleet: Fleet) -> tuple[Fraction, int, int, Fraction]:
    """Return the scaled squared distance (m²) of two UAVs i < j and their d̂_min: no other two are closer for theirs."""
    if not fleet.members:
        return (*closest_pair(points, fleet.base.theta_inverse), fleet.base.d_hat_min)
    found: list[tuple[Fraction, int, int, Fraction]] = []
    for i, j in combinations(range(len(points)), 2):
        both = fleet.pair(fleet.members[i], fleet.members[j])
        square, _, _ = closest_pair((points[i], points[j]), both.theta_inverse)
        found.append((square, i, j, both.d_hat_min))
    return min(found, key=lambda one: one[0] / one[3] ** 2)


def _text(value: Fraction | float, bound: Fraction, side: str) -> str:
    """Return `value`, which is on this `side` (less, more) of `bound`, be it by a little only."""
    short = f"{float(value):.6g}"
    return short if short != f"{float(bound):.6g}" else f"{short} (rounded; a little {side})"
