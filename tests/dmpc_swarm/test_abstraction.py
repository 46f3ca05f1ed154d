"""What the explored states leave out cannot matter: Abstraction.ESSENTIAL and COUNTED are exact, names are free."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations, product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmproof.claims.claim import Always
from swarmproof.dmpc_swarm import rounds as rounds_module
from swarmproof.dmpc_swarm import symmetry as identities
from swarmproof.dmpc_swarm.claims.protocol import CLAIMS
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.protocol.algorithm1 import ComputeUnit, CuState
from swarmproof.dmpc_swarm.protocol.algorithm2 import InformationTracker
from swarmproof.dmpc_swarm.protocol.messages import Metadata, Trajectory
from swarmproof.dmpc_swarm.protocol.swarm import Swarm
from swarmproof.dmpc_swarm.protocol.uav import Uav
from swarmproof.dmpc_swarm.rounds import Rounds
from swarmproof.dmpc_swarm.semantics import PRESETS, Semantics
from swarmproof.dmpc_swarm.symmetry import Abstraction, canonical_swarm, forget
from swarmproof.explore.search import Exploration, Limits, explore
from swarmproof.explore.steps import PARENT_BITS

ESSENTIAL, COUNTED, NOTHING = Abstraction.ESSENTIAL, Abstraction.COUNTED, Abstraction.NOTHING


class Image:
    """The map from the swarms of a finer engine to those of a coarser one.

    Under the round-robin trigger, two trajectories that were calculated for one UAV in one round keep the order of
    their names, although nothing depends on it; so equality is meant up to their exchange.
    """

    def __init__(self, fine: Rounds, coarse: Rounds) -> None:
        self.fine, self.coarse = fine, coarse
        self._of: dict[int, int] = {}
        self._least: dict[int, int] = {}

    def __call__(self, key: int) -> int:
        """Return the coarse key of a fine one."""
        coarse = self._of.get(key)
        if coarse is None:
            coarse = self._of[key] = self.of_coarse(self.coarse.pack(self.fine.unpack(key)))
        return coarse

    def of_coarse(self, key: int) -> int:
        """Return the least coarse key of those that differ from this one by an exchange within a round."""
        if not self.coarse.ages_matter:
            return key
        least = self._least.get(key)
        if least is None:
            least = self._least[key] = self._least_exchange(key)
        return least

    def _least_exchange(self, key: int) -> int:
        swarm = self.coarse.unpack(key)
        exchanges = [_within_rounds(trajectories(swarm, i)) for i in range(len(swarm.uavs))]
        if all(len(of_uav) == 1 for of_uav in exchanges):
            return key
        return min(self.coarse.pack(renamed(swarm, list(names), swarm.k)) for names in product(*exchanges))


def _within_rounds(names: list[Trajectory]) -> list[dict[Trajectory, Trajectory]]:
    """Return every renaming that exchanges trajectories of one round."""
    by_round: dict[int, list[Trajectory]] = {}
    for name in names:
        by_round.setdefault(name.metadata.round, []).append(name)
    orders = product(*(permutations(of_round) for of_round in by_round.values()))
    return [
        {
            old: new
            for olds, news in zip(by_round.values(), order, strict=True)
            for old, new in zip(olds, news, strict=True)
        }
        for order in orders
    ]


def truth(rounds: Rounds, key: int) -> tuple[bool, ...]:
    """Return which claims' predicates are true in a swarm."""
    swarm = observe(rounds.unpack(key))
    return tuple(
        not claim.broken_in(swarm) if isinstance(claim.question, Always) else claim.question.goal(swarm)
        for claim in CLAIMS
    )


def to_depth(rounds: Rounds, depth: int) -> Exploration:
    """Return what is reachable within `depth` rounds."""
    return explore(rounds, on_level=lambda exploration, _: exploration.depth == depth)


def ranked(exploration: Exploration) -> Iterator[tuple[int, tuple[int, int]]]:
    """Yield every key with its depth and the fewest losses on a way of that depth."""
    for index, key in enumerate(exploration.keys):
        yield key, (exploration.depth_of(index), exploration.losses[index])


def is_image(image: Image, fine: Exploration, coarse: Exploration) -> bool:
    """Say whether the coarse exploration is the image of the fine one, with the same depths and fewest losses."""
    best: dict[int, tuple[int, int]] = {}
    for key, rank in ranked(fine):
        best[image(key)] = min(rank, best.get(image(key), rank))
    expected: dict[int, tuple[int, int]] = {}
    for key, rank in ranked(coarse):
        expected[image.of_coarse(key)] = min(rank, expected.get(image.of_coarse(key), rank))
    return best == expected


def same_truth(image: Image, fine: Exploration) -> bool:
    """Say whether every claim is true of a swarm if and only if it is true of its image."""
    of_image: dict[int, tuple[bool, ...]] = {}
    for key in fine.keys:
        coarse = image(key)
        if coarse not in of_image:
            of_image[coarse] = truth(image.coarse, coarse)
        if truth(image.fine, key) != of_image[coarse]:
            return False
    return True


def bisimilar(image: Image, keys: list[int], chunk: int = 5000) -> bool:
    """Say whether every swarm has, after one round, the images and fewest losses that its own image has."""
    coarse_rounds: dict[int, dict[int, int]] = {}
    for begin in range(0, len(keys), chunk):
        some = keys[begin : begin + chunk]
        after: list[dict[int, int]] = [{} for _ in some]
        fine = image.fine
        for tagged, value in fine.run({key | n << fine.tag_at: 0 for n, key in enumerate(some)}).items():
            mine = after[tagged >> fine.tag_at]
            coarse = image(tagged & (1 << fine.key_bits) - 1)
            mine[coarse] = min(value >> PARENT_BITS, mine.get(coarse, value >> PARENT_BITS))
        for key, mine in zip(some, after, strict=True):
            coarse = image(key)
            if coarse not in coarse_rounds:
                following = coarse_rounds[coarse] = {}
                for key_after, value in image.coarse.run({coarse: 0}).items():
                    other = image.of_coarse(key_after)
                    following[other] = min(value >> PARENT_BITS, following.get(other, value >> PARENT_BITS))
            if mine != coarse_rounds[coarse]:
                return False
    return True


BOUNDED = [
    (2, 2, "printed", ("initial=known",), 3),
    (2, 2, "printed", (), 6),
    (2, 2, "prose", ("initial=known",), 4),
    (2, 2, "guarded", ("initial=known", "request_order=any"), 3),
    (2, 2, "prose", ("initial=known", "slot_conflict=both-lost", "request_order=round-robin"), 4),
    (2, 2, "prose", ("initial=known", "event_trigger=round-robin"), 4),
    (2, 2, "printed", ("initial=known", "event_trigger=round-robin"), 3),
    (2, 2, "ignore-loss", (), 6),
    (2, 2, "ignore-loss", ("event_trigger=round-robin",), 6),
    (3, 2, "prose", ("initial=known",), 2),
    (3, 2, "printed", ("initial=known",), 2),
    (2, 3, "prose", ("initial=known",), 2),
]


@pytest.mark.parametrize(
    ("uavs", "cus", "preset", "overrides", "depth", "abstraction"),
    [(*case, ESSENTIAL) for case in BOUNDED] + [(*BOUNDED[number], COUNTED) for number in (1, 2, 6, 11)],
)
def test_what_is_reached_unabstracted_is_what_the_abstraction_reaches(
    uavs: int, cus: int, preset: str, overrides: tuple[str, ...], depth: int, abstraction: Abstraction
) -> None:
    """Within some rounds, abstracting what is reached equals reaching it abstracted; depths, losses, claims agree."""
    semantics = Semantics.parse(preset, overrides)
    image = Image(Rounds(uavs, cus, semantics, NOTHING), Rounds(uavs, cus, semantics, abstraction))
    fine, coarse = to_depth(image.fine, depth), to_depth(image.coarse, depth)
    assert is_image(image, fine, coarse)
    assert same_truth(image, fine)


def check_against_counted(semantics: Semantics, max_states: int | None = None) -> None:
    """Compare ESSENTIAL with COUNTED: everything reachable, every claim, every single round."""
    image = Image(Rounds(2, 2, semantics, COUNTED), Rounds(2, 2, semantics, ESSENTIAL))
    fine = explore(image.fine, limits=Limits(max_states=max_states))
    if max_states is None:
        assert is_image(image, fine, explore(image.coarse))
    assert same_truth(image, fine)
    assert bisimilar(image, fine.keys)


@pytest.mark.deep
def test_essential_is_bisimilar_to_counted_under_guarded() -> None:
    """Under `guarded`, ESSENTIAL is the image of all that COUNTED reaches, and behaves alike in every round."""
    check_against_counted(Semantics.parse("guarded"))


@pytest.mark.parametrize(
    ("preset", "overrides"),
    [
        ("printed", ()),
        ("prose", ()),
        ("ignore-loss", ()),
        ("prose", ("event_trigger=round-robin",)),
        ("printed", ("event_trigger=round-robin", "initial=known")),
    ],
)
def test_essential_is_bisimilar_to_counted_on_a_part(preset: str, overrides: tuple[str, ...]) -> None:
    """On the swarms of the first rounds, a swarm and what ESSENTIAL keeps of it behave alike."""
    check_against_counted(Semantics.parse(preset, overrides), max_states=1500)


@pytest.mark.deep
@pytest.mark.parametrize(
    ("preset", "overrides"),
    [
        ("printed", ()),
        ("prose", ()),
        ("ignore-loss", ()),
        ("printed", ("initial=known", "request_order=any")),
        ("prose", ("slot_conflict=both-lost",)),
        ("prose", ("slot_conflict=cu-wins",)),
        ("guarded", ("request_order=round-robin",)),
        ("ignore-loss", ("event_trigger=round-robin",)),
    ],
)
def test_essential_is_bisimilar_to_counted(preset: str, overrides: tuple[str, ...]) -> None:
    """ESSENTIAL is the image of all that COUNTED reaches, and behaves alike in every round."""
    check_against_counted(Semantics.parse(preset, overrides))


def _one_entry_or_none(
    tracker: InformationTracker, w: int, followed: Trajectory, semantics: Semantics
) -> InformationTracker:
    """Forget the number of a deprecated tracker's entries, which line 12 as printed still asks for."""
    kept = forget(tracker, w, followed, semantics)
    return kept._replace(trajectories=tuple(t for t in kept.trajectories if t == followed)) if kept.deprecated else kept


def _only_the_number(
    tracker: InformationTracker, w: int, followed: Trajectory, semantics: Semantics
) -> InformationTracker:
    """Forget whether a deprecated tracker holds the followed trajectory, which line 5 still asks for."""
    kept = forget(tracker, w, followed, semantics)
    return InformationTracker((), deprecated=True) if kept.deprecated else kept


@pytest.mark.parametrize(
    ("preset", "planted"),
    [("printed", _one_entry_or_none), ("prose", _only_the_number), ("printed", _only_the_number)],
)
def test_forgetting_too_much_is_noticed(preset: str, planted: object, monkeypatch: pytest.MonkeyPatch) -> None:
    """The comparison with COUNTED fails if ESSENTIAL forgets what can still matter."""
    monkeypatch.setattr(identities, "forget", planted)
    monkeypatch.setattr(rounds_module, "forget", planted)
    semantics = Semantics.parse(preset, ["initial=known"])
    image = Image(Rounds(2, 2, semantics, COUNTED), Rounds(2, 2, semantics, ESSENTIAL))
    fine = explore(image.fine, limits=Limits(max_states=1500))
    assert not bisimilar(image, fine.keys)
    image = Image(Rounds(2, 2, semantics, NOTHING), Rounds(2, 2, semantics, ESSENTIAL))
    assert not is_image(image, to_depth(image.fine, 4), to_depth(image.coarse, 4))


def test_forgetting_the_number_is_harmless_under_the_prose() -> None:
    """Under deprecation=one, `forget` keeps the followed trajectory of a deprecated tracker and nothing else."""
    followed, other, third = (Trajectory(Metadata(k, 0)) for k in range(3))
    held = InformationTracker((other, followed, third), deprecated=True)
    unheld = InformationTracker((other, third), deprecated=True)
    for preset in ("prose", "guarded"):
        semantics = Semantics.parse(preset)
        assert forget(held, 1, followed, semantics).trajectories == (followed,)
        assert forget(unheld, 1, followed, semantics).trajectories == ()


def test_a_tracker_that_is_up_to_date_is_not_touched() -> None:
    """Nothing is forgotten of a tracker that is not deprecated."""
    followed, other = (Trajectory(Metadata(k, 0)) for k in range(2))
    tracker = InformationTracker((other, followed), deprecated=False)
    for preset in PRESETS:
        assert forget(tracker, 0, followed, Semantics.parse(preset)) == tracker


# --- names ---------------------------------------------------------------------------------------------------------


@st.composite
def swarms(draw: st.DrawFn, ages: bool) -> Swarm:
    """Draw a swarm of two or three UAVs and one to three CUs, in round 10 or 11, reachable or not."""
    uavs, cus = draw(st.integers(2, 3)), draw(st.integers(1, 3))
    flags = [
        draw(st.sampled_from([(False,) * 3, (True,) * 3, (True, False, False), (False, True, True)]))
        for _ in range(cus)
    ]
    rounds_ = st.integers(-1, 9)
    followed, contents = [], []
    for _ in range(uavs):
        # a CU calculates one trajectory of a UAV in a round: its metadata are unique
        pool = draw(
            st.lists(st.builds(Metadata, rounds_, st.integers(0, cus - 1)), min_size=1, max_size=5, unique=True)
        )
        names = [Trajectory(metadata) for metadata in pool]
        followed.append(draw(st.sampled_from(names)))
        contents.append([tuple(draw(st.lists(st.sampled_from(names), max_size=4, unique=True))) for _ in range(cus)])
    return Swarm(
        draw(st.integers(10, 11)),
        tuple(Uav(i, followed[i], frozenset(draw(st.sets(st.integers(0, cus - 1))))) for i in range(uavs)),
        tuple(
            ComputeUnit(
                w,
                # a CU runs only while nothing is deprecated
                draw(st.sampled_from(list(CuState)[1 if any(flags[w]) else 0 :])),
                tuple(InformationTracker(contents[i][w], flags[w][i]) for i in range(uavs)),
                a_et=tuple(range(min(uavs, cus))) if ages else None,
            )
            for w in range(cus)
        ),
    )


def renamed(swarm: Swarm, names: list[dict[Trajectory, Trajectory]], k: int) -> Swarm:
    """Return the swarm with other names for its trajectories (by UAV) and another round."""
    return Swarm(
        k,
        tuple(Uav(uav.i, names[uav.i][uav.followed], uav.asked_by) for uav in swarm.uavs),
        tuple(
            ComputeUnit(
                cu.w,
                cu.state,
                tuple(
                    InformationTracker(tuple(names[i][t] for t in tracker.trajectories), tracker.deprecated)
                    for i, tracker in enumerate(cu.trackers)
                ),
                cu.next_request,
                cu.a_et,
            )
            for cu in swarm.cus
        ),
    )


def trajectories(swarm: Swarm, i: int) -> list[Trajectory]:
    """Return all trajectories of UAV i that occur in the swarm, in order."""
    held = {t for cu in swarm.cus for t in cu.trackers[i].trajectories}
    return sorted(held | {swarm.uavs[i].followed})


PRESET_NAMES = st.sampled_from([name for name in PRESETS if name != "ignore-loss"])
ABSTRACTIONS = st.sampled_from(list(Abstraction))


@settings(deadline=None, max_examples=200)
@given(swarm=swarms(ages=False), data=st.data(), preset=PRESET_NAMES, abstraction=ABSTRACTIONS)
def test_names_do_not_matter_without_ages(
    swarm: Swarm, data: st.DataObject, preset: str, abstraction: Abstraction
) -> None:
    """Under event_trigger=any, a swarm and the same with its trajectories renamed have one representative."""
    names = []
    for i in range(len(swarm.uavs)):
        mine = trajectories(swarm, i)
        fresh = [Trajectory(Metadata(100 + number, number % 2)) for number in range(len(mine))]
        names.append(dict(zip(mine, data.draw(st.permutations(fresh)), strict=True)))
    semantics = Semantics.parse(preset)
    k = data.draw(st.integers(500, 503))
    assert canonical_swarm(renamed(swarm, names, k), semantics, abstraction) == canonical_swarm(
        swarm, semantics, abstraction
    )


@settings(deadline=None, max_examples=200)
@given(swarm=swarms(ages=True), data=st.data(), preset=PRESET_NAMES, abstraction=ABSTRACTIONS)
def test_only_the_order_of_ages_matters(
    swarm: Swarm, data: st.DataObject, preset: str, abstraction: Abstraction
) -> None:
    """Under round-robin, moving the rounds of all UAVs' trajectories apart in order changes no representative."""
    gaps = data.draw(st.lists(st.integers(1, 5), min_size=11, max_size=11))
    new_round = {old: sum(gaps[: old + 1]) for old in range(-1, 10)}
    names = [
        {t: Trajectory(Metadata(new_round[t.metadata.round], t.metadata.cu)) for t in trajectories(swarm, i)}
        for i in range(len(swarm.uavs))
    ]
    k = swarm.k + len(swarm.cus) * data.draw(st.integers(10, 20))
    semantics = Semantics.parse(preset, ["event_trigger=round-robin"])
    assert canonical_swarm(renamed(swarm, names, k), semantics, abstraction) == canonical_swarm(
        swarm, semantics, abstraction
    )


@settings(deadline=None, max_examples=300)
@given(swarm=st.booleans().flatmap(lambda ages: swarms(ages=ages)), preset=PRESET_NAMES, abstraction=ABSTRACTIONS)
def test_a_representative_represents_itself(swarm: Swarm, preset: str, abstraction: Abstraction) -> None:
    """Taking the representative of a representative changes nothing."""
    trigger = "any" if swarm.cus[0].a_et is None else "round-robin"
    semantics = Semantics.parse(preset, [f"event_trigger={trigger}"])
    once = canonical_swarm(swarm, semantics, abstraction)
    assert canonical_swarm(once, semantics, abstraction) == once


@settings(deadline=None, max_examples=100)
@given(swarm=swarms(ages=False), preset=PRESET_NAMES)
def test_a_representative_shows_the_same(swarm: Swarm, preset: str) -> None:
    """A swarm and its representative agree on every claim about trackers, under every abstraction."""
    semantics = Semantics.parse(preset)
    for abstraction in Abstraction:
        shown, plain = observe(canonical_swarm(swarm, semantics, abstraction)), observe(swarm)
        for claim in CLAIMS:
            assert claim.broken_in(shown) == claim.broken_in(plain)
