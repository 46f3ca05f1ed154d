"""How a swarm begins: who is too close by the measure of its own pair, and that rounding makes nobody so."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest
from tests.dmpc_swarm.flight.settings import setting

from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.flight.exhaustive import PatternVerdict, explore_flights
from swarmproof.dmpc_swarm.flight.run import fly
from swarmproof.errors import BadInput
from swarmproof.faults.grammar import parse
from swarmproof.motion.lattice import Lattice
from swarmproof.scenario.scenario import Scenario, load

#: Two UAVs that are to fly away from each other.
TEXT = """
name = "two"
rounds = 3
[parameters]
workspace = [[-2, 2], [-2, 2], [0.4, 3]]
d_hat_min = 0.25
d_min = 0.1
[start]
positions = [[0.1, 0, 1], [0.4, 0, 1]]
[[targets]]
round = 0
positions = [[-1, 0, 1], [1, 0, 1]]
"""
KIND = "[[kinds]]\nuavs = [0, 1]\n{}\n[start]"


def two(folder: Path, *replacements: tuple[str, str], changes: tuple[str, ...] = ()) -> Scenario:
    """Return the two UAVs with some of the text replaced."""
    text = TEXT
    for old, new in replacements:
        assert old in text
        text = text.replace(old, new)
    path = folder / "two.toml"
    path.write_text(text, encoding="utf-8")
    return load(str(path), 0, changes)


def verdicts(scenario: Scenario, rounds: int = 3) -> dict[str, Verdict]:
    """Return what becomes of each claim in a flight without loss."""
    flown, _ = fly(setting(scenario), parse("none", scenario.uavs, 2, 0), rounds)
    return {judged.claim.id: judged.verdict for judged in flown.claims}


def test_small_uavs_begin_apart_by_their_own_distance(tmp_path: Path) -> None:
    """UAVs that are small by their kind do not begin in violation, though they are closer than others must be."""
    small = two(tmp_path, ("d_hat_min = 0.25", "d_hat_min = 0.5"), ("[start]", KIND.format("d_hat_min = 0.2")))
    assert small.begins_too_close == ""
    assert verdicts(small)["theorem-2"] is Verdict.NOT_VIOLATED


def test_large_uavs_begin_too_close_by_their_own_distance(tmp_path: Path) -> None:
    """UAVs that are large by their kind begin in violation, so that what rests on Remark 2 says nothing of them."""
    large = two(tmp_path, ("[start]", KIND.format("d_hat_min = 0.5")), changes=("begin=anyhow",))
    assert large.begins_too_close == "UAV 0 and UAV 1 start 0.3 m apart, less than d_hat_min=0.5 m"
    found = verdicts(large)
    assert {found[claim] for claim in ("tracked-separation", "theorem-2", "eq-2")} == {Verdict.NOT_APPLICABLE}


#: Exactly d̂_min = 0.25011 m apart, and coordinates of no lattice of powers of two.
EXACT = [
    (("d_hat_min = 0.25\n", "d_hat_min = 0.25011\n"), ("[0.1, 0, 1], [0.4,", f"[{low}, 0, 1], [{high},"))
    for low, high in (("0.1", "0.35011"), ("0.00001", "0.25012"), ("0.55555", "0.80566"))
]


@pytest.mark.parametrize("replacements", EXACT)
def test_who_may_begin_anyhow_is_not_made_to(tmp_path: Path, replacements: tuple[tuple[str, str], ...]) -> None:
    """A swarm that begins exactly d̂_min apart violates nothing, also where it might begin closer."""
    exact = two(tmp_path, *replacements, changes=("begin=anyhow",))
    assert exact.begins_too_close == ""
    assert Verdict.VIOLATED not in verdicts(exact).values()


def test_rounding_of_starts_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """If starts were rounded to the nearest lattice points, these claims would be called violated."""
    monkeypatch.setattr(Lattice, "holding", lambda self, points: self)
    assert verdicts(two(tmp_path, *EXACT[0]))["theorem-2"] is Verdict.VIOLATED
    assert verdicts(crash(tmp_path))["eq-2"] is Verdict.VIOLATED


def crash(folder: Path) -> Scenario:
    """Return two UAVs that begin exactly d_min apart, as crashes count."""
    return two(
        folder, ("d_min = 0.1", "d_min = 0.25011\ncrash_theta_inverse = 0.5"), ("[0.4, 0, 1]]", "[0.60022, 0, 1]]")
    )


def test_who_begins_without_a_crash_is_not_made_to(tmp_path: Path) -> None:
    """UAVs that begin exactly d_min apart, as crashes count, and then part do not violate eq. (2)."""
    assert verdicts(crash(tmp_path))["eq-2"] is not Verdict.VIOLATED


def test_starts_that_are_too_close_are_disturbed_like_others(tmp_path: Path) -> None:
    """Jitter moves a swarm that may begin anyhow, and refuses one that may not."""
    close = ("[0.4, 0, 1]]", "[0.2, 0, 1]]")
    anyhow = two(tmp_path, close, changes=("begin=anyhow", "jitter=0.01"))
    assert all(abs(x - at) <= Fraction(1, 100) for (x, _, _), at in zip(anyhow.starts, (0.1, 0.2), strict=True))
    with pytest.raises(BadInput, match="the starts of UAV 0 and UAV 1 are too close"):
        two(tmp_path, close, changes=("jitter=0.01",))


#: What is refused before a flight: what is changed, what is said.
REFUSED = [
    (("tracking_error=5000",), "tracking_error=5000 is too large for exact distances in this flight: at most 4"),
    (("delay=0.1",), "delay=0.1 says nothing of a flight"),
]


@pytest.mark.parametrize(("changes", "said"), REFUSED)
def test_what_cannot_be_flown_is_refused_before(tmp_path: Path, changes: tuple[str, ...], said: str) -> None:
    """What has no meaning in a flight, or no room in its numbers, is refused in a sentence before it begins."""
    with pytest.raises(BadInput, match=said):
        setting(two(tmp_path, changes=changes)).flight()


def test_scalings_of_hundreds_of_digits_are_refused(tmp_path: Path) -> None:
    """A crash's scaling whose entries have no common unit below 2⁵³ is refused in a sentence, however long that is."""
    x, y, z = (f'"{7 ** (55 + n)}/{7 ** (55 + n) + 2}"' for n in range(3))
    off = f'"1/{3**95}"'
    rows = f"[[{x}, {off}, 0], [{off}, {y}, 0], [0, 0, {z}]]"
    many = two(tmp_path, ("d_min = 0.1", f"d_min = 0.1\ncrash_theta_inverse = {rows}"))
    with pytest.raises(BadInput, match="or of crash_theta_inverse, have too many digits for exact distances"):
        setting(many).flight()


def test_what_recovery_brings_in_is_no_violation_of_lemma_4(tmp_path: Path) -> None:
    """A swarm that begins too close breaks no lemma when a tracker becomes valid again: (18) said nothing of it."""
    close = two(tmp_path, ("[0.4, 0, 1]]", "[0.2, 0, 1]]"), changes=("begin=anyhow",))
    found = explore_flights(setting(close), 2, lambda *_: None)
    assert PatternVerdict.VIOLATED not in {decided.verdict for decided in found.claims}
    of_lemma_4 = {decided.verdict for decided in found.claims if decided.claim.id == "lemma-4"}
    assert of_lemma_4 == {PatternVerdict.NOT_APPLICABLE}
