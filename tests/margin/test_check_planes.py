"""The checker's half-planes and polygons, part by part: against exact motions, and against plain fractions."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from random import Random
from typing import Any

import pytest
from tests.margin.hand_made import made

from swarmproof.margin.check_motions import Problem, after, parameters_of, problem_of
from swarmproof.margin.check_numbers import Rejected, Vector
from swarmproof.margin.check_planes import Edge, Polygon, clip, edges_of, largest, polygon_of

F = Fraction
Point = tuple[Fraction, Fraction]


def a_problem(reading: str, order: int, **changes: Any) -> Problem:
    """Return the problem of a hand-made certificate with other parameters."""
    return problem_of(parameters_of(made(reading, order)["parameters"] | changes, False), reading, False)


def an_edge(problem: Problem, tau: str, way: tuple[str, str], proof: list[list[Any]]) -> Edge:
    """Return the edge that a proof proves at one time of the first window."""
    edges = [{"direction": list(way), "proofs": [proof, proof]}]
    (edge,) = edges_of(problem, 1, F(0), (F(tau), F(tau)), edges)
    return edge


# ---- what multipliers and densities cost


def excursion(order: int, speed: Fraction, share: Fraction) -> list[tuple[Fraction, Vector]]:
    """Return a scalar motion on [0, 1] by pieces (duration, state and input): fast back, then as fast forth.

    In between, the velocity turns within `share`, with the least acceleration that does that for a constant input.
    """
    turn = share / 2
    if order == 2:
        bend = 2 * speed / share
        pieces = [((1 - share) / 2, F(0)), (share, bend), ((1 - share) / 2, F(0))]
    else:
        jerk = 2 * speed / turn**2
        pieces = [((1 - share) / 2, F(0)), (turn, jerk), (turn, -jerk), ((1 - share) / 2, F(0))]
    state: Vector = (F(0), -speed, *[F(0)] * (order - 2))
    motion = []
    for duration, constant in pieces:
        motion.append((duration, (*state, constant)))
        state = after((*state, constant), duration)[:-1]
    return motion


def at(motion: list[tuple[Fraction, Vector]], time: Fraction) -> Vector:
    """Return position and derivatives of a motion by pieces at a time."""
    for duration, state in motion:
        if time <= duration:
            return after(state, time)
        time -= duration
    raise AssertionError("after the end")


def reached(motion: list[tuple[Fraction, Vector]], tau: Fraction, way: Point) -> Fraction:
    """Return αδ + βg of a motion on [0, 1] at tau."""
    first, there, last = (at(motion, time)[0] for time in (F(0), tau, F(1)))
    return way[0] * (last - first) + way[1] * ((1 - tau) * first + tau * last - there)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_density_costs_the_sizes_of_its_rates(sign: int) -> None:
    """Densities whose rates change their sign cost as much as both sizes: with signed rates, g would be too small.

    The sagitta of a motion with |w'| ≤ 2v that goes back for half of the window, and forth for the other half, is
    nearly v. With ∫ρ in place of a bound of ∫|ρ|, two densities would prove that it is at most v/2, for free.
    """
    problem = a_problem("whole-motion", 3, v_max=["1", "1", "1"], a_max=["40", "40", "40"], j_max=["900", "900", "900"])
    bounds = problem.bounds[0]
    # g(1/2) = (w'(1) − w'(0))/8 + ∫ρw'', ρ antisymmetric about 1/4 and about 3/4
    less, more = (str(F(one * sign, 8)) for one in (-1, 1))
    proof = [["0", 1, less], ["1", 1, more], ["0", "1/2", 2, less, more], ["1/2", "1", 2, more, less]]
    edge = an_edge(problem, "1/2", ("0", str(sign)), proof)
    assert edge.weights[0] == (F(0), F(1, 4), F(1, 8), F(0))
    motion = [(d, tuple(sign * x for x in state)) for d, state in excursion(3, bounds[1], F(1, 5))]
    assert all(abs(state[k]) <= bounds[k] for _, state in motion for k in (1, 2, 3))
    found = reached(motion, F(1, 2), (F(0), F(sign)))
    assert bounds[1] / 4 < found <= edge.offset(problem, F(0), bounds)
    for one in (0, 1):  # each size counts on its own
        rates = [rate if n == one else "0" for n, rate in enumerate((less, more))]
        single = an_edge(problem, "1/2", ("0", "1"), [["0", "1/2", 2, *rates]])
        assert single.weights[0][2] >= F(1, 32)


def random_proof(random: Random, problem: Problem) -> list[list[Any]]:
    """Return multipliers, and densities where they are allowed, at times that the reading has."""
    times = {"initial-state": ["0"], "whole-motion": ["0", "1/3", "1/2", "1"], "as-sampled": ["0", "1/2", "1"]}
    proof: list[list[Any]] = []
    for _ in range(random.randrange(4)):
        d, nu = random.randint(1, problem.order - 1), str(F(random.randint(-6, 6), 4))
        proof.append([random.choice(times[problem.reading]), d, nu])
    for _ in range(random.randrange(3) if problem.reading == "whole-motion" else 0):
        low, high = sorted(random.sample(range(7), 2))
        d, first = random.randint(1, problem.order - 1), F(random.randint(-6, 6), 4)
        last = first if d == 1 else F(random.randint(-6, 6), 4)
        proof.append([str(F(low, 6)), str(F(high, 6)), d, str(first), str(last)])
    return proof + [[str(F(random.randint(-3, 9), 6)), 1, "0"] for _ in range(random.randrange(4))]


def random_motion(random: Random, problem: Problem) -> list[tuple[Fraction, Vector]]:
    """Return a motion by pieces, of any size."""
    state = tuple(F(random.randint(-9, 9)) for _ in range(problem.order))
    cuts = [F(0), *sorted(F(random.randint(1, 11), 12) for _ in range(random.randrange(4))), F(1)]
    if problem.reading == "as-sampled":
        cuts = [F(0), F(1)]
    motion = []
    for begin, end in pairwise(cuts):
        piece = (*state, F(random.randint(-9, 9)))
        motion.append((end - begin, piece))
        state = after(piece, end - begin)[:-1]
    return motion


def sizes(problem: Problem, motion: list[tuple[Fraction, Vector]]) -> Vector:
    """Return the bounds, by derivative, that a motion keeps with none to spare: where its reading looks.

    Derivatives between the order and the first are looked at from 0 to `until`, at multiples of `step`; that there may
    be a turn in a piece counts for order 3, where the velocity is a parabola.
    """
    times = {
        "initial-state": [F(0)],
        "whole-motion": [F(n, 12) for n in range(13)],
        "as-sampled": [F(0), F(1, 2), F(1)],
    }
    looked = [at(motion, time) for time in times[problem.reading]]
    if problem.reading == "whole-motion" and problem.order == 3:
        for duration, state in motion:
            turn = -state[2] / state[3] if state[3] else F(0)
            looked += [after(state, turn)] if 0 < turn < duration else []
    found = [max(abs(state[d]) for state in looked) for d in range(1, problem.order)]
    return (F(0), *found, max(abs(state[-1]) for _, state in motion))


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("reading", ["initial-state", "whole-motion", "as-sampled"])
def test_no_motion_goes_beyond_an_edge(reading: str, order: int) -> None:
    """Whatever multipliers, densities and direction: no motion has a larger αδ + βg than its own bounds allow."""
    random, problem = Random(f"{reading} {order}"), a_problem(reading, order)
    near = 0
    for _ in range(40):
        tau, way = F(random.randint(0, 6), 6), (F(random.randint(-4, 4), 2), F(random.randint(-8, 8), 2))
        if not any(way):
            continue
        edge = an_edge(problem, str(tau), (str(way[0]), str(way[1])), random_proof(random, problem))
        for _ in range(6):
            motion = random_motion(random, problem)
            bounds = sizes(problem, motion)
            most = sum(w * b for w, b in zip(edge.weights[0], bounds, strict=True))
            found = abs(reached(motion, tau, way))
            assert found <= most
            near += 3 * found > 2 * most > 0
    assert near > 0


def test_breakpoints_outside_the_motion_change_nothing() -> None:
    """Multipliers of 0 before the start or after the end neither cost nor spare anything, however many there are."""
    for reading, order in (("initial-state", 2), ("initial-state", 3), ("whole-motion", 3)):
        problem = a_problem(reading, order)
        for way in (("1", "-6"), ("1", "3"), ("-2", "5")):
            plain = an_edge(problem, "1/2", way, [["1/4", 1, "0"]])
            outside = [[time, 1, "0"] for time in ("-1/3", "-1", "-7", "-2", "5", "8", "1/4")]
            assert an_edge(problem, "1/2", way, outside) == plain


# ---- polygons in plain fractions


def points(polygon: Polygon) -> list[Point]:
    """Return the corners as fractions."""
    assert all(w > 0 for _, _, w in polygon)
    return [(F(x, w), F(y, w)) for x, y, w in polygon]


def clipped(corners: list[Point], a: Fraction, b: Fraction, c: Fraction) -> list[Point]:
    """Return the corners of what is left where aδ + bg ≤ c, walking along the sides."""
    left = []
    for (x0, y0), (x1, y1) in pairwise([*corners[-1:], *corners]):
        before, here = a * x0 + b * y0 - c, a * x1 + b * y1 - c
        if before * here < 0:
            share = before / (before - here)
            left.append((x0 + share * (x1 - x0), y0 + share * (y1 - y0)))
        if here <= 0:
            left.append((x1, y1))
    return left


def random_polygon(random: Random) -> tuple[Polygon, list[Point]]:
    """Return a rectangle cut by some lines with small numbers: corners are often on a line."""
    far, off = F(random.randint(1, 6), random.randint(1, 3)), F(random.randint(1, 6), random.randint(1, 3))
    polygon = polygon_of({(F(1), F(0)): far, (F(0), F(1)): off})
    corners = [(far, off), (-far, off), (-far, -off), (far, -off)]
    for _ in range(random.randrange(5)):
        a, b, c = (F(random.randint(-4, 4), random.randint(1, 2)) for _ in range(3))
        polygon, corners = clip(polygon, a, b, c), clipped(corners, a, b, c)
    return polygon, corners


def test_polygons_are_cut_exactly() -> None:
    """The corners are those of plain fractions, in the same order, none twice, none beyond the line."""
    random, empty, cut = Random(4), 0, 0
    for _ in range(200):
        polygon, corners = random_polygon(random)
        assert points(polygon) == corners
        empty += not corners
        cut += len(corners) > 4
    assert empty > 10
    assert cut > 10


def test_directions_cut_on_both_sides() -> None:
    """Each further direction bounds a polygon on two opposite sides, |αδ + βg| ≤ its offset."""
    random = Random(5)
    for _ in range(40):
        far, off = F(random.randint(1, 6)), F(random.randint(1, 6), 2)
        offsets: dict[Vector, Fraction] = {(F(1), F(0)): far, (F(0), F(1)): off}
        corners = [(far, off), (-far, off), (-far, -off), (far, -off)]
        for _ in range(random.randrange(3)):
            alpha, beta = F(random.randint(-3, 3)), F(random.randint(1, 3))
            if alpha:
                offsets[alpha, beta] = F(random.randint(0, 9), 2)
        for (alpha, beta), offset in offsets.items():
            corners = clipped(clipped(corners, alpha, beta, offset), -alpha, -beta, offset)
        assert points(polygon_of(offsets)) == corners
    for missing in ((F(1), F(0)), (F(0), F(1))):
        with pytest.raises(Rejected, match="not among the directions"):
            polygon_of({way: offset for way, offset in offsets.items() if way != missing})


def highest(form: Vector, corners: list[Point]) -> Fraction:
    """Return the largest value of a form on the sides of a polygon: at a corner, or where it turns on a side."""
    p, r, s = form

    def value(x: Fraction, y: Fraction) -> Fraction:
        return p * x * x + 2 * r * x * y + s * y * y

    found = [value(*corner) for corner in corners]
    for (x0, y0), (x1, y1) in pairwise([*corners[-1:], *corners]):
        start, end, middle = value(x0, y0), value(x1, y1), value((x0 + x1) / 2, (y0 + y1) / 2)
        bent, slope = 2 * (start + end - 2 * middle), 4 * middle - 3 * start - end
        turn = -slope / (2 * bent) if bent else F(0)
        if 0 < turn < 1:
            found.append(value(x0 + turn * (x1 - x0), y0 + turn * (y1 - y0)))
    return max(found)


def test_the_largest_value_of_a_form_is_exact() -> None:
    """The largest value on the boundary is found exactly: negative, zero or positive, at corners and within sides."""
    random, inside = Random(6), 0
    for _ in range(300):
        polygon, corners = random_polygon(random)
        if corners:
            form = tuple(F(random.randint(-5, 5), random.randint(1, 3)) for _ in range(3))
            expected = highest(form, corners)
            assert largest(form, polygon) == expected
            p, r, s = form
            inside += expected not in [p * x * x + 2 * r * x * y + s * y * y for x, y in corners]
    assert inside > 15
