"""Δd_min,cont as an interval: search, proof, exact check, and the certificate that carries them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from swarmproof.margin.ascent import Ascent, Candidate
from swarmproof.margin.certificate import certificate, read_witness
from swarmproof.margin.check import check
from swarmproof.margin.climb import Climb
from swarmproof.margin.extremes import Extremes, extremes
from swarmproof.margin.norms import BallProver
from swarmproof.margin.problem import Problem
from swarmproof.margin.prove import Blocked, Budget, Cell, WindowProver
from swarmproof.margin.witness import Witness, exact_witness
from swarmproof.theorem3.delay import displacement, lost
from swarmproof.theorem3.inequality import Truth, corrected, printed
from swarmproof.theorem3.parameters import Parameters, Reading
from swarmproof.theorem3.values import NORMS, Vector, closed

#: Widths of the interval (relative to d̂_min) that are tried one after the other, until one fails.
WIDTHS = (Fraction(1, 100), Fraction(5, 10**5))
#: A width that is a bonus: it is tried with a small budget.
NARROWEST = Fraction(5, 10**6)
#: Widths for where even the first one fails.
WIDE = (Fraction(1, 10), Fraction(1, 3))
#: Cells of τ, and parts of them, that one attempt may look at.
LARGE_BUDGET = 2000, 3000
#: The same for the bonus: in one window, in each further one, and where every cell takes many linear programs.
SMALL_BUDGET, SMALL_BUDGET_MORE, SMALL_BUDGET_SLOW = (60, 500), (20, 100), (24, 250)
#: The same steps where bounds of the norm couple the axes: a box beside them may keep the interval wide.
NORM_WIDTHS = tuple(Fraction(1, parts) for parts in (3, 10, 30, 60, 100, 140, 200, 500, 1000, 3000, 10**4, 10**5))
NORM_BUDGET = 120, 120
#: Improvements of the witness during one attempt.
MOST_IMPROVEMENTS = 30

Say = Callable[[str], None]
#: Per window the dip (m) that was proved to be an upper bound, and the proof.
Proofs = dict[int, tuple[Fraction, list[Cell]]]


@dataclass(frozen=True)
class Margin:
    """Δd_min,cont is between `lower` and `upper` (m, exact), for the problem's reading; the exact checker agreed.

    `witness` is the pair behind *lower*, None where that is 0; `certificate` proves both, as JSON objects. `flown` are
    bounds of how far one UAV flies in the time `delay` (m, scaled). `attained` is False where the two UAVs are of kinds
    that need not be able to fly the witness.
    """

    problem: Problem
    lower: Fraction
    upper: Fraction
    witness: Witness | None
    certificate: dict[str, Any]
    flown: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0))
    attained: bool = True

    @property
    def known(self) -> tuple[Fraction, Fraction]:
        """Return the bounds of Δd_min,cont (m) that verdicts may rest on."""
        return self.lower if self.attained else Fraction(0), self.upper

    @property
    def loss(self) -> tuple[Fraction, Fraction]:
        """Return the same with what one UAV flies in the time `delay`."""
        given, reading = self.problem.parameters, self.problem.reading
        (low, high), flown = self.known, self.flown
        return lost(given, reading, low, flown[0])[0], lost(given, reading, high, flown[1])[1]

    @property
    def closest(self) -> tuple[Vector, Vector] | None:
        """Return where the witness's UAVs are at their closest approach (m); None if nobody is known to fly it."""
        if self.witness is None or not self.attained:
            return None
        time = self.witness.start + self.witness.tau
        i, j = ([axis.position(time) for axis in uav] for uav in (self.witness.uav_i, self.witness.uav_j))
        return (i[0], i[1], i[2]), (j[0], j[1], j[2])

    @property
    def truths(self) -> tuple[Truth, Truth]:
        """Return whether (26) holds as printed, and corrected."""
        given = self.problem.parameters
        return printed(given, *self.known), corrected(given, *self.loss, self.closest)

    @property
    def by_norms(self) -> bool:
        """Say whether the proof of *upper* takes the bounds of the norm as such, not only the box around the ball."""
        return any(cell.get("ball") for one in self.certificate["windows"] or () for cell in one["cells"])


class Solver:
    """Searches one problem: witnesses from below, proofs from above."""

    def __init__(self, problem: Problem, say: Say = lambda message: None) -> None:
        self.problem, self._say = problem, say
        distinct = list(dict.fromkeys(problem.axes))
        self._kinds = tuple(distinct.index(bounds) for bounds in problem.axes)
        self._by_kind: list[Extremes] = [extremes(problem, bounds) for bounds in distinct]
        self._ascents: dict[int, Ascent] = {}
        self.witness: Witness | None = None
        #: The largest dip found if no workspace confined the pair (m); proofs ignore the workspace.
        self.reached = Fraction(0)

    @property
    def lower(self) -> Fraction:
        """Return the largest exact dip found so far, m."""
        return self.witness.dip if self.witness else Fraction(0)

    def search(self) -> None:
        """Look for a witness in every window."""
        for window in self.problem.windows:
            self._say(f"searching window {window + 1} of {len(self.problem.windows)}")
            for candidate in self._candidates(window):
                self._take(candidate)
            if self.lower == self.problem.parameters.d_hat_min:
                return
        if self.problem.parameters.workspace is not None:
            self._search_flat()

    def _search_flat(self) -> None:
        """Look for witnesses that do not move along the axes on which the workspace has no room for two UAVs."""
        given, still = self.problem.parameters, Fraction(0)
        assert given.workspace is not None
        sizes = [
            float(high - low) * abs(self.problem.scaling[:, k]).max()
            for k, (low, high) in enumerate(closed(given.workspace))
        ]
        wide = [size >= self.problem.distance for size in sizes]

        def limited(bounds: Vector) -> Vector:
            x, y, z = (bound if room else still for bound, room in zip(bounds, wide, strict=True))
            return x, y, z

        flat = replace(given, v_max=limited(given.v_max), a_max=limited(given.a_max), j_max=limited(given.j_max))
        solver = Solver(Problem(flat, self.problem.reading))
        for window in self.problem.windows:
            for candidate in solver._candidates(window):
                self._take(candidate)

    def above(self, width: Fraction) -> Callable[[], Fraction]:
        """Return what gives the dip that is `width`·d̂_min above the largest one found so far, with ten decimals."""
        return lambda: _rounded_up(self.reached + width * self.problem.parameters.d_hat_min)

    def _candidates(self, window: int) -> Iterable[Candidate]:
        """Return pairs that come close in one window."""
        return Climb(self.problem, window).candidates() if self.problem.coupled else self._ascent(window).from_scratch()

    def _ascent(self, window: int) -> Ascent:
        if window not in self._ascents:
            self._ascents[window] = Ascent(self.problem, self._by_kind, self._kinds, window)
        return self._ascents[window]

    def _take(self, candidate: Candidate) -> None:
        """Keep the candidate if it is exactly feasible and better."""
        if candidate.dip > float(self.reached) + 1e-13:
            free = exact_witness(self.problem, candidate, confined=False)
            self.reached = max(self.reached, free.dip if free else self.reached)
        if candidate.dip > float(self.lower) + 1e-13:
            witness = exact_witness(self.problem, candidate)
            if witness is not None and witness.dip > self.lower:
                self.witness = witness

    def prove(
        self,
        upper: Callable[[], Fraction],
        done: Proofs,
        before: Proofs | None = None,
        limits: tuple[int, int] = LARGE_BUDGET,
        by: type[WindowProver] = WindowProver,
    ) -> bool:
        """Prove that no dip exceeds `upper()` (m), which may grow as better witnesses are found; say whether it worked.

        `done` receives what was proved per window, and keeps what is still good; `before` are weaker proofs to go on
        from; `by` is what proves. It fails as soon as a witness is found that exceeds an upper bound that does not
        grow.
        """
        budget, improvements = Budget(*limits), 0
        for window in self.problem.windows:
            prover = by(self.problem, self._by_kind, self._kinds, window)
            while window not in done or done[window][0] > upper():
                goal = upper()
                self._say(f"proving dip ≤ {float(goal):.7f} m, window {window + 1} of {len(self.problem.windows)}")
                earlier, start = self.reached, before[window][1] if before and window in before else ()

                def refuted(blocked: Blocked, here: int = window, goal: Fraction = goal) -> bool:
                    if self.problem.coupled:  # the pairs of boxes that it asks about break the norms
                        return False
                    ascent = self._ascent(here)
                    candidate = ascent.from_corner(blocked, float(goal), float(self.reached))
                    if candidate is not None:
                        self._take(candidate)
                    return self.reached > goal

                closest, spare = float(self.problem.parameters.d_hat_min - goal), float(goal - self.reached)
                cells = prover.prove(closest, spare, budget, refuted, start)
                if not isinstance(cells, Blocked):
                    done[window] = (goal, cells)
                    continue
                improvements += 1
                if self.reached <= earlier or improvements > MOST_IMPROVEMENTS or budget.spent:
                    return False
                if self.reached > upper():
                    return False
        return True


def margin(problem: Problem, say: Say = lambda message: None) -> Margin:
    """Return Δd_min,cont of `problem` as an interval with a certificate, which has passed the exact check.

    Raises:
        BadInput: parameters that the reading does not take.
    """
    distance = problem.parameters.d_hat_min
    solver = Solver(problem, say)
    solver.search()
    proofs = [] if solver.reached >= distance else _coupled_proofs(solver) if problem.coupled else _proofs(solver)
    return certified(solver, proofs, say)


def _proofs(solver: Solver) -> list[Proofs]:
    """Return proofs from polygons per axis, the narrowest one last."""
    problem, proofs = solver.problem, list[Proofs]()
    more = len(problem.windows) - 1
    small = SMALL_BUDGET[0] + more * SMALL_BUDGET_MORE[0], SMALL_BUDGET[1] + more * SMALL_BUDGET_MORE[1]
    if problem.reading is Reading.WHOLE_MOTION and problem.order == 3:
        small = SMALL_BUDGET_SLOW
    for width in (*WIDTHS, NARROWEST):
        done: Proofs = {}
        limits = small if width == NARROWEST else LARGE_BUDGET
        if not solver.prove(solver.above(width), done, proofs[-1] if proofs else None, limits):
            break
        proofs.append(done)
    for width in WIDE if not proofs else ():
        done = {}
        if solver.prove(solver.above(width), done):
            proofs.append(done)
            break
    return proofs


def _coupled_proofs(solver: Solver) -> list[Proofs]:
    """Return proofs from bounds of the norm and, where these do better, from the box around the ball alone."""
    proofs, best = list[Proofs](), solver.problem.parameters.d_hat_min
    for width in NORM_WIDTHS if solver.problem.diagonal else ():
        done: Proofs = {}
        if not solver.prove(solver.above(width), done, proofs[-1] if proofs else None, NORM_BUDGET, BallProver):
            break
        proofs.append(done)
        best = max(goal for goal, _ in done.values())
    box = Solver(_box(solver.problem))
    box.search()
    # a pair within the box refutes whatever knows of the box only
    boxed = _proofs(box) if box.reached < best else []
    return [*proofs, *(done for done in boxed if max(goal for goal, _ in done.values()) < best)]


def provers(problem: Problem) -> tuple[type[WindowProver], ...]:
    """Return what can prove an upper bound, the best one first."""
    return (BallProver, WindowProver) if problem.coupled and problem.diagonal else (WindowProver,)


def _box(problem: Problem) -> Problem:
    """Return the problem whose only bounds are those per axis that the box and the norms give together."""
    halves = [tuple(bound / 2 for bound in (*(b for _, b in axis.derivatives), axis.input)) for axis in problem.axes]
    names = list(NORMS.items())
    boxes: dict[str, Any] = {
        box: tuple(half[m] for half in halves) for m, (_, box) in enumerate(names[: problem.order])
    }
    free: dict[str, Any] = dict.fromkeys(NORMS)
    return Problem(replace(problem.parameters, **boxes, **free), problem.reading)


def _rounded_up(value: Fraction) -> Fraction:
    """Return the next number with ten decimals."""
    return Fraction(-((-value * 10**10) // 1), 10**10)


def certified(solver: Solver, proofs: list[Proofs], say: Say) -> Margin:
    """Return the narrowest interval that the exact checker accepts."""
    problem, witness = solver.problem, solver.witness
    distance = problem.parameters.d_hat_min
    for done in reversed(proofs):
        upper = max(goal for goal, _ in done.values())
        if solver.lower <= upper < distance:
            say("checking the certificate")
            content = certificate(
                problem, solver.lower, upper, witness, {window: cells for window, (_, cells) in done.items()}
            )
            check(content)
            flown = displacement(problem.parameters, problem.reading)
            return Margin(problem, solver.lower, upper, witness, content, flown)
    content = certificate(problem, solver.lower, distance, witness, None)
    check(content)
    return Margin(problem, solver.lower, distance, witness, content, displacement(problem.parameters, problem.reading))


def from_certificate(content: object) -> Margin:
    """Return the margin that a certificate (decoded JSON) proves, after checking it.

    Raises:
        Rejected: it proves nothing, or something else than it says.
    """
    verified = check(content)
    assert isinstance(content, dict)
    problem = Problem(Parameters.from_exact(content["parameters"]), Reading(content["reading"]))
    witness = None if content["witness"] is None else read_witness(problem, content["witness"])
    flown = displacement(problem.parameters, problem.reading)
    return Margin(problem, verified.lower, verified.upper, witness, content, flown)
