"""Evidence about real trajectories that are not planned again, about round 0, and about where a plan begins."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import partial

from swarmproof.algebra.later import Later
from swarmproof.algebra.polynomial import Number, constant
from swarmproof.dmpc_swarm.evidence.feasibility import known_time, line, still_apart
from swarmproof.dmpc_swarm.proofs.feasibility import ALIGNED, BEYOND
from swarmproof.dmpc_swarm.proofs.rest import (
    HOVERS,
    LITERAL,
    NO_REST,
    START,
    TOO_SHORT,
    one_entry_is,
    round_0,
)
from swarmproof.dmpc_swarm.proofs.terms.motion import Timing, row
from swarmproof.dmpc_swarm.proofs.terms.problem import LINE, apart_at, entries, place, times_18, times_20, times_21
from swarmproof.prove.evidence import Candidate, Certificate, Evidence, Vectors, term

#: Fly towards each other at speed 1, without a jerk: 4 apart at 0, 2 at T = 1, at the same place at 2T.
_TOWARDS = line((0, 1, 0, 0), (4, -1, 0, 0), 2)
#: UAV i comes to rest at 4 at 2T, being at 3 at T; UAV j hovers at 5.
_ENDS_CLOSE = line((0, 0, 12, -18, 6), (5,), 2)
#: Two UAVs leave 0 in opposite directions: 0.152 m apart at 0.1 s, 0.253 m at T = 0.2 s, 0.36 m from 3T on. Each brakes
#: with jerk ±5 for 3T and is at rest then: with s = 3T − t, a = −5s, v = 5s²/2 and p = 0.18 − 5s³/6 of UAV i.
FROM_ONE_PLACE = Vectors({"p_i": Fraction(0), "v_i": Fraction(9, 10), "a_i": Fraction(-3), "u_i_0": Fraction(5)})


def _hovers_apart(timing: Timing) -> Candidate:
    """Return why UAVs that hover in round 0 are as far apart there as at T."""
    i, j = (entries(name, timing, LINE) for name in "ij")
    t = timing.period
    certificates = []
    for time in round_0(timing):
        left = t - time
        total = sum(((place(j, at) - place(i, at))[0] for at in (time, t)), constant(0))
        # n(time) − n(T) = −(v(T − time) + a(T² − time²)/2 + u(T³ − time³)/6), the difference of UAV j's and i's
        moved: tuple[tuple[str, Number], ...] = (
            ("v_{}", left),
            ("a_{}", (t**2 - time**2) / 2),
            ("u_{}_0", (t**3 - time**3) / 6),
        )
        equations = {
            f"{symbol.format(name)} = 0": total * (-sign * factor)
            for symbol, factor in moved
            for name, sign in (("j", 1), ("i", -1))
        }
        certificates.append(Certificate((term(apart_at(t)),), equations))
    return Candidate({}, certificates)


def _assumed(timing: Timing) -> Candidate:
    """Return why UAVs that are apart at the samples of round 0 are."""
    return Candidate({}, tuple(Certificate((term(apart_at(time)),)) for time in round_0(timing)))


def ends_apart(timing: Timing, given: list[Fraction]) -> Candidate:
    """Return why entries that end at rest remain apart."""
    i, j = (entries(name, timing, LINE) for name in "ij")
    certificates = []
    for time in times_21(timing):
        earlier = known_time(timing, time, given)
        certificates.append(Certificate((term(apart_at(earlier)),), still_apart(timing, time, earlier, i, j)))
    return Candidate({}, certificates)


def _lemma_4(times: Callable[[Timing], list[Fraction]], known: str) -> dict[str, Callable[[], Evidence]]:
    return {
        f"from {known}, {name}": partial(ends_apart, timing, times(timing))
        for name, timing in {**ALIGNED, **BEYOND}.items()
    }


#: The old trajectory hovers at 0; the other leaves in the first round with jerk 6, and comes to rest at 6 at 3T.
_JUMPS = Vectors(
    {
        **{f"{name}_i": Fraction(0) for name in "pva"},
        **{f"u_a_{n}": Fraction(0) for n in range(3)},
        **{f"u_b_{n}": Fraction(jerk) for n, jerk in enumerate((6, -12, 6))},
    }
)
_STATE = ("position", "velocity", "acceleration")


def by_jerk(period: Fraction) -> dict[str, Fraction]:
    """Return by what the first jerk is multiplied in the state at T."""
    return dict(zip(_STATE, (period**3 / 6, period**2 / 2, period), strict=True))


EVIDENCE: Mapping[str, Mapping[str, Evidence]] = {
    "lemma-4/printed": {LITERAL: Certificate((term(apart_at(Fraction(1))),))},
    "lemma-4-use/printed": {NO_REST: Vectors(_TOWARDS), TOO_SHORT: Vectors(_ENDS_CLOSE)},
    "lemma-4-use/repaired": Later({**_lemma_4(times_18, "(18)"), **_lemma_4(times_20, "(20)")}),
    "theorem-2-base/printed": dict.fromkeys(START, FROM_ONE_PLACE),
    "theorem-2-base/repaired": Later(
        {f"{name}, hovering": partial(_hovers_apart, timing) for name, timing in HOVERS.items()}
        | {f"{name}, apart in round 0": partial(_assumed, timing) for name, timing in HOVERS.items()}
    ),
    "unique-entry/printed": dict.fromkeys(_STATE, _JUMPS),
    "unique-entry/repaired": {
        name: Certificate((), {one_entry_is(0): constant(-factor)}) for name, factor in by_jerk(Fraction(1)).items()
    },
    "entry-jump/repaired": {
        name: Certificate(
            (term(row("(13c)", "a", "u 0 ≤"), factor=factor), term(row("(13c)", "b", "u 0 ≥"), factor=factor))
        )
        for name, factor in by_jerk(Fraction(1, 5)).items()
    },
}
