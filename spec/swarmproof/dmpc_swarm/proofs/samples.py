"""Claims about index ranges and time shifts: does the conclusion of one step give the hypothesis of the next?

Samples are counted from the start of round k; m = T/T_c. A trajectory planned in round k begins at sample m and is at
rest from sample m + mH on; the entries of D(k) are at rest from sample mH on. Unless said otherwise, h_c = mH.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from swarmproof.algebra.grid import Range, Step, Time
from swarmproof.claims.proof import ProofClaim, ProofVerdict, Question, Reading

#: The ratios T/T_c that are decided.
RATIOS = (1, 2, 3, 4)


def _by_ratio(step: Callable[[int], Step]) -> Mapping[str, Question]:
    return {f"T/T_c = {m}": step(m) for m in RATIOS}


def eq_18(m: int) -> Range:
    """Return the samples of (18): h = 1 … h_c at time hT_c + T of round k − 1, which is kT + hT_c."""
    return Range("(18)", Time(1), Time(0, m))


def eq_19(m: int) -> Range:
    """Return the samples of (19): h = 1 … h_c at time hT_c of round k, which is kT + hT_c as well."""
    return Range("(19)", Time(1), Time(0, m))


def eq_20(m: int, short: int = 0) -> Range:
    """Return the samples of (20): h = 0 … h_c − 1 at time hT_c + 2T of round k − 1, where h_c = mH − short."""
    return Range("(20)", Time(m), Time(m - 1 - short, m))


def eq_21(m: int, short: int = 0) -> Range:
    """Return the samples of (21): h = 1 … h_c at time hT_c + T of round k, where h_c = mH − short."""
    return Range("(21)", Time(m + 1), Time(m - short, m))


def planes(m: int, short: int = 0) -> Range:
    """Return the samples of (13f): h = 0 … h_c at time T + hT_c of round k, where h_c = mH − short."""
    return Range("(13f)", Time(m), Time(m - short, m))


def flown(m: int, rounds: int) -> Range:
    """Return the samples of round k + `rounds`, at which the references are flown (23)."""
    return Range("(23)", Time(rounds * m), Time(rounds * m + m - 1))


def next_round(each: Range, m: int) -> Range:
    """Return the range of round k + 1 that `each` is in round k."""
    return Range(f"{each.name} of round k+1", each.first.plus(m), each.last.plus(m))


def rest(m: int, new: bool = False) -> Time:
    """Return from which sample on the entries of D(k) are at rest; `new`: those of D(k+1)."""
    return Time(m if new else 0, m)


def repaired_20(m: int, short: int = 0) -> Range:
    """Return the samples that (20) should have: h = 0 … h_c."""
    return Range("(20) with h = 0 … h_c", Time(m), Time(m - short, m))


def repaired_21(m: int, short: int = 0) -> Range:
    """Return the samples that (21) should have: h = 0 … h_c."""
    return Range("(21) with h = 0 … h_c", Time(m), Time(m - short, m))


def new_ones(m: int) -> Range:
    """Return the samples of (16) and (17): h = 1 … h_c at time hT_c + T of round k."""
    return Range("(16), (17)", Time(m + 1), Time(m, m))


def begins(m: int) -> Range:
    """Return the first sample of a trajectory planned in round k, where it is where the old one is (13b)."""
    return Range("(20) at h = 0, with (13b)", Time(m), Time(m))


def _chain(m: int) -> Mapping[str, Step]:
    """Return the steps of the repaired induction."""
    return {
        "the candidate satisfies (13f)": Step((repaired_20(m),), planes(m), None),
        "pairs with a new trajectory": Step((new_ones(m), begins(m)), repaired_21(m), None),
        "pairs of old trajectories": Step((repaired_20(m),), repaired_21(m), rest(m)),
        "the next round": Step((repaired_21(m),), next_round(repaired_20(m), m), rest(m, new=True)),
        "what is flown": Step((repaired_21(m),), flown(m, 1), None),
    }


def _chains() -> Mapping[str, Question]:
    return {f"T/T_c = {m}: {name}": step for m in RATIOS for name, step in _chain(m).items()}


def _horizons(shorts: Sequence[int]) -> Mapping[str, Question]:
    """Return what is needed of h_c: that the candidate is apart at all samples of (13f), and that (21) gives (20)."""
    return {
        f"T/T_c = {m}, h_c = {m}H{-short:+d}: {name}": step
        for m in RATIOS
        for short in shorts
        for name, step in {
            # with a single sample less for H = 1 and T = T_c there would be none at all
            "the candidate": Step((eq_20(m, short),), planes(m, short), rest(m), 2),
            "the next round": Step((eq_21(m, short),), next_round(eq_20(m, short), m), rest(m, new=True), 2),
        }.items()
    }


_PRINTED, _REPAIRED = Reading.PRINTED, Reading.REPAIRED
_PROVED, _FALSE = ProofVerdict.PROVED, ProofVerdict.FALSE
_ALL = "For every H ≥ 1 and T/T_c = 1, 2, 3, 4."
_REST = f"{_ALL} Terminal rest (13e), h_c·T_c = H·T."
_NO_REST = f"{_ALL} h_c·T_c = H·T; nothing is said about the time after the last sample."

CLAIMS: tuple[ProofClaim, ...] = (
    ProofClaim(
        "lemma-4-samples",
        _PRINTED,
        "Lemma 4 gives (21) for two UAVs that were not planned.",
        "Lemma 4: (18) and (19); proof of Theorem 1",
        _NO_REST,
        _by_ratio(lambda m: Step((eq_19(m),), eq_21(m), None)),
        _FALSE,
        "(18) and (19) speak of the same samples, kT + T_c … kT + h_cT_c: Lemma 4 says nothing new. (21) needs "
        "T/T_c samples more.",
    ),
    ProofClaim(
        "lemma-4-samples",
        _REPAIRED,
        "(18) gives (21) for two UAVs that were not planned, if their trajectories end at rest.",
        "Lemma 4",
        _REST,
        _by_ratio(lambda m: Step((eq_18(m),), eq_21(m), rest(m))),
        _PROVED,
        "The samples that are missing are all after the end, where the distance is that of the last one.",
    ),
    ProofClaim(
        "lemma-4-hypothesis",
        _PRINTED,
        "Theorem 1's hypothesis (20) gives Lemma 4's (18).",
        "Proof of Theorem 1",
        _REST,
        _by_ratio(lambda m: Step((eq_20(m),), eq_18(m), rest(m))),
        _FALSE,
        "Only for T = T_c. Otherwise (18) also wants samples of round k, of which (20) says nothing.",
    ),
    ProofClaim(
        "lemma-4-hypothesis",
        _REPAIRED,
        "(20) gives (21) for two UAVs that were not planned, if their trajectories end at rest.",
        "Proof of Theorem 1",
        _REST,
        _by_ratio(lambda m: Step((eq_20(m),), eq_21(m), rest(m))),
        _PROVED,
        "Lemma 4 with (20) for its hypothesis: the samples that (20) lacks are not needed.",
    ),
    ProofClaim(
        "candidate-samples",
        _PRINTED,
        "(20) says that the old trajectories are d̂_min apart at all samples of (13f).",
        "eq. (22), for h = 0 … h_c; Lemma 3 where j is in A_ET(k)",
        _NO_REST,
        _by_ratio(lambda m: Step((eq_20(m),), planes(m), None)),
        _FALSE,
        "(20) ends at h = h_c − 1, (13f) at h_c. Theorem 1 assumes (13e), which fills it if h_c·T_c ≥ H·T; (22) does "
        "not say that it is used.",
    ),
    ProofClaim(
        "candidate-samples",
        _REPAIRED,
        "(20) says that the old trajectories are d̂_min apart at all samples of (13f), if they end at rest.",
        "eq. (22); Lemma 3",
        _REST,
        _by_ratio(lambda m: Step((eq_20(m),), planes(m), rest(m))),
        _PROVED,
        "At the last sample, both have been at rest for T.",
    ),
    ProofClaim(
        "next-round",
        _PRINTED,
        "Theorem 1's conclusion (21) is its hypothesis (20) of the next round.",
        "Proof of Theorem 2: “we apply induction to Theorem 1”",
        _NO_REST,
        _by_ratio(lambda m: Step((eq_21(m),), next_round(eq_20(m), m), None)),
        _FALSE,
        "Only for T = T_c. Otherwise T/T_c − 1 samples at the end are missing.",
    ),
    ProofClaim(
        "next-round",
        _REPAIRED,
        "Theorem 1's conclusion (21) is its hypothesis (20) of the next round, if trajectories end at rest.",
        "Proof of Theorem 2",
        _REST,
        _by_ratio(lambda m: Step((eq_21(m),), next_round(eq_20(m), m), rest(m, new=True))),
        _PROVED,
        "But Theorem 1 does not conclude (13e).",
    ),
    ProofClaim(
        "horizon",
        _PRINTED,
        "The induction goes through whatever h_c·T_c is; here, one sample less than H·T.",
        "Theorem 1: h_c and H are not related",
        "For every H ≥ 2 and T/T_c = 1, 2, 3, 4. Terminal rest (13e).",
        _horizons((1,)),
        _FALSE,
        "For T = T_c the candidate can break (13f) at its last sample; for larger T, (21) does not give (20).",
    ),
    ProofClaim(
        "horizon",
        _REPAIRED,
        "The induction goes through if h_c·T_c ≥ H·T.",
        "Theorem 1",
        "For every H ≥ 2 and T/T_c = 1, 2, 3, 4. Terminal rest (13e); h_c·T_c is H·T, or T_c or 2T_c more.",
        _horizons((0, -1, -2)),
        _PROVED,
        "The horizon of (13f) must reach the end of the trajectories; the published h_c = 30, H = 15, T/T_c = 2 does.",
    ),
    ProofClaim(
        "theorem-2-start",
        _PRINTED,
        "(20) at k = 0 separates the references at all samples of round 0.",
        "Theorem 2, eq. (23) for k = 0",
        _REST,
        _by_ratio(lambda m: Step((eq_20(m),), flown(m, 0), rest(m))),
        _FALSE,
        "(20) at k = 0 begins with round 1. In round 0, two UAVs may fly through each other.",
    ),
    ProofClaim(
        "theorem-2-start",
        _REPAIRED,
        "(20) at k = 0, and the same at the samples of round 0, separate the references at all samples of round 0.",
        "Theorem 2",
        _ALL,
        _by_ratio(
            lambda m: Step((Range("the same at the samples of round 0", Time(0), Time(m - 1)),), flown(m, 0), None)
        ),
        _PROVED,
        "True of UAVs that hover at the start, d̂_min apart (Remark 2).",
    ),
    ProofClaim(
        "first-sample",
        _PRINTED,
        "(21) separates the references at all samples of round k+1.",
        "Theorem 2, eq. (23)",
        _REST,
        _by_ratio(lambda m: Step((eq_21(m),), flown(m, 1), rest(m, new=True))),
        _FALSE,
        "(21) begins with h = 1: it lacks the first sample of the round, the only one if T = T_c.",
    ),
    ProofClaim(
        "first-sample",
        _REPAIRED,
        "(21), and (20) at h = 0, separate the references at all samples of round k+1.",
        "Theorem 2",
        f"{_REST} A new trajectory begins where the old one is (13b).",
        _by_ratio(lambda m: Step((eq_21(m), begins(m)), flown(m, 1), rest(m, new=True))),
        _PROVED,
        "At its first sample, a new trajectory is where the old one is.",
    ),
    ProofClaim(
        "chain",
        _REPAIRED,
        "With h = 0 … h_c in (20) and in (21), each step gives the hypothesis of the next: candidate, all pairs, next "
        "round, and what is flown.",
        "Theorems 1 and 2",
        f"{_REST} A new trajectory begins where the old one is (13b).",
        _chains(),
        _PROVED,
        "This is the induction of docs/proofs.md.",
    ),
)
