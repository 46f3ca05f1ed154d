"""Loss models: repeatable whatever the order, and with the frequencies and windows that they are named after."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from hashlib import sha256
from itertools import pairwise
from math import log, sqrt

import numpy as np
import pytest

from swarmproof.errors import BadInput
from swarmproof.faults.forms import FORMS
from swarmproof.faults.grammar import parse
from swarmproof.faults.losses import Burst, Iid, Jam, Losses, LossModel, Recorded, nothing_lost
from swarmproof.faults.pattern import Pairs

N, M = 16, 3
DRAWN = pytest.mark.parametrize("spec", ["iid:0.1", "iid:1/3", "burst:0.05,0.4"])
EVERY = pytest.mark.parametrize("spec", ["none", "iid:0.1", "burst:0.05,0.4", "jam:3,5"])


def model(spec: str, seed: int = 7, target_change: int = 0) -> LossModel:
    """Return a loss model for 16 UAVs and 3 CUs."""
    return parse(spec, N, M, seed, target_change)


def arrays(losses: Losses) -> tuple[Pairs, ...]:
    """Return the five arrays: three of losses, two of decoded replies."""
    return losses.cu_uav, losses.cu_slot, losses.uav_slot, losses.replies_at_cus, losses.replies_at_uavs


def flat(losses: Losses) -> Pairs:
    """Return all marks in one row."""
    return np.concatenate([array.ravel() for array in arrays(losses)])


def same(one: Losses, other: Losses) -> bool:
    """Return whether two rounds are equal in every mark."""
    return all(np.array_equal(a, b) for a, b in zip(arrays(one), arrays(other), strict=True))


def deviation(variance: float) -> float:
    """Return how far a sum strays from its mean with a probability of at most 1e-12, if its variance is at most that.

    Bernstein (independent terms) and Freedman (martingale differences, `variance` bounding the predictable one): with
    terms of at most 1, P(|S| ≥ t) ≤ 2 exp(−t² / (2 (V + t/3))), which is 1e-12 for the t returned.
    """
    log_odds = log(2e12)
    return log_odds / 3 + sqrt(log_odds**2 / 9 + 2 * log_odds * variance)


def is_binomial(count: int, n: int, p: float) -> bool:
    """Return whether `count` of `n` independent events of probability `p` is credible (to 1e-12)."""
    return abs(count - n * p) <= deviation(n * p * (1 - p))


# --- what all models have in common --------------------------------------------------------------------------------


@EVERY
def test_shapes_and_read_only(spec: str) -> None:
    """Every model gives boolean arrays of the documented shapes that cannot be written to."""
    for k in (0, 1, 4, 100):
        losses = model(spec).losses(k)
        assert [a.shape for a in arrays(losses)] == [(M, N), (M, M), (N, M), (M, M), (N, M)]
        for array in arrays(losses):
            assert array.dtype == np.bool_
            with pytest.raises(ValueError, match="read-only"):
                array[0, 0] = True


def in_any_order(models: Sequence[LossModel]) -> bool:
    """Return whether two models agree, asked forwards, backwards and twice."""
    first, second = models
    asked = {k: first.losses(k) for k in range(40)}
    backwards = {k: second.losses(k) for k in reversed(range(40))}
    return all(same(asked[k], backwards[k]) and same(asked[k], first.losses(k)) for k in range(40))


@EVERY
def test_losses_depend_on_the_round_only(spec: str) -> None:
    """Two models of the same text and seed agree in every round, in whatever order and however often they are asked."""
    assert in_any_order([model(spec), model(spec)])


def test_a_model_with_one_stream_of_draws_is_noticed() -> None:
    """The test above fails for a model that goes on drawing at each call."""

    class Streaming(Iid):
        def losses(self, k: int) -> Losses:
            self.calls = getattr(self, "calls", 0) + 1
            return super().losses(self.calls)

    assert not in_any_order([Streaming(N, M, Fraction(1, 10), 7) for _ in range(2)])


@DRAWN
def test_seeds_give_other_losses(spec: str) -> None:
    """Another seed gives other losses."""
    assert any(not same(model(spec, 7).losses(k), model(spec, 8).losses(k)) for k in range(1, 20))


@pytest.mark.parametrize(
    ("spec", "digest"), [("iid:0.1", "65b6f389f29dbc03"), ("burst:0.05,0.4", "13ebdece2a290b12")], ids=["iid", "burst"]
)
def test_drawn_losses_are_the_same_for_ever(spec: str, digest: str) -> None:
    """What is drawn in the first 50 rounds with seed 7 is what was drawn when this test was written."""
    drawn = model(spec)
    marks = np.packbits(np.concatenate([flat(drawn.losses(k)) for k in range(50)]))
    assert sha256(marks.tobytes()).hexdigest()[:16] == digest


def test_large_seeds_are_seeds() -> None:
    """Seeds of more than 128 bits are taken, and all of their bits matter."""
    assert not same(model("iid:0.5", 1 << 200).losses(0), model("iid:0.5", 1 << 201).losses(0))


# --- none, recorded ------------------------------------------------------------------------------------------------


def test_none_loses_nothing() -> None:
    """Under `none` everything arrives in every round, and conflicts give the CU's message."""
    for k in (0, 1, 10_000):
        assert not flat(model("none").losses(k)).any()


def test_recorded_losses_end() -> None:
    """Recorded losses are those of the list, round by round; after its end everything arrives."""
    rounds = [model("iid:0.5").losses(k) for k in range(3)]
    recorded = Recorded(rounds, N, M)
    assert [recorded.losses(k) for k in range(3)] == rounds
    assert same(recorded.losses(3), nothing_lost(N, M))
    assert same(recorded.losses(1000), nothing_lost(N, M))


def test_count_is_of_lost_pairs() -> None:
    """`count` counts the pairs marked as lost, and not the replies that are decoded."""
    rng = np.random.default_rng(1)
    marks = [rng.random(shape) < 0.5 for shape in ((M, N), (M, M), (N, M), (M, M), (N, M))]
    assert Losses(*marks).count == sum(int(array.sum()) for array in marks[:3])
    assert Losses(*[np.zeros_like(a) for a in marks[:3]], *[np.ones_like(a) for a in marks[3:]]).count == 0


def test_arrays_must_fit() -> None:
    """Losses whose arrays are about different numbers of UAVs or CUs are refused."""
    good = arrays(nothing_lost(4, 2))
    Losses(*good)
    for number in range(5):
        for shape in ((3, 3), (2, 3), (5, 2)):
            with pytest.raises(ValueError, match="does not fit"):
                Losses(*(np.zeros(shape, bool) if i == number else array for i, array in enumerate(good)))


# --- iid -----------------------------------------------------------------------------------------------------------


def lost_cells(drawn: LossModel, rounds: int) -> np.ndarray:
    """Return (rounds, cells): the marks of losses of each round in one row."""
    return np.array([flat(drawn.losses(k))[: M * N + M * M + N * M] for k in range(rounds)])


@pytest.mark.parametrize("p", [Fraction(1, 100), Fraction(1, 10), Fraction(1, 3), Fraction(9, 10)])
def test_iid_frequency(p: Fraction) -> None:
    """Of 105,000 pairs, as many are lost as independent losses with P allow; those of another P are too many or few."""
    count = int(lost_cells(model(f"iid:{p}"), 1000).sum())
    pairs = 1000 * (M * N + M * M + N * M)
    assert is_binomial(count, pairs, float(p))
    wrong = p * Fraction(6, 5) if p < Fraction(1, 2) else p * Fraction(9, 10)
    if p > Fraction(1, 50):  # 1.2 % cannot be told from 1 % by this many
        assert not is_binomial(int(lost_cells(model(f"iid:{wrong}"), 1000).sum()), pairs, float(p))


def test_iid_frequency_of_every_pair() -> None:
    """Each pair, replies in donated slots among them, is lost with P; each coin falls on both sides."""
    counts = lost_cells(model("iid:0.1"), 3000).sum(axis=0)
    assert all(is_binomial(int(count), 3000, 0.1) for count in counts)
    assert not is_binomial(0, 3000, 0.1)
    coins = np.array([flat(model("iid:0.1").losses(k))[M * N + M * M + N * M :] for k in range(3000)])
    assert all(is_binomial(int(count), 3000, 0.5) for count in coins.sum(axis=0))


def both_lost(drawn: LossModel) -> int:
    """Return how often CU 0 and CU 1 both lose the metadata of the same UAV, in 3,000 rounds."""
    return sum(int((a[0] & a[1]).sum()) for a in (drawn.losses(k).cu_uav for k in range(3000)))


def test_iid_receivers_are_independent() -> None:
    """Two CUs lose the same message as often as independent losses allow: in P² of all cases."""
    assert is_binomial(both_lost(model("iid:0.1")), 3000 * N, 0.01)


def test_a_loss_shared_by_receivers_is_noticed() -> None:
    """The test above fails for a model in which a message is lost for all receivers or for none."""

    class Shared(Iid):
        def losses(self, k: int) -> Losses:
            _, *others = arrays(super().losses(k))
            return Losses(np.tile(super().losses(k).cu_uav[0], (M, 1)), *others)

    assert not is_binomial(both_lost(Shared(N, M, Fraction(1, 10), 7)), 3000 * N, 0.01)


def agreements_are_chance(rounds: Sequence[np.ndarray]) -> bool:
    """Return whether fair marks of rounds 2r and 2r+1 agree as often as chance does, at every shift against each other.

    At one shift, the agreements of disjoint pairs of rounds are independent and fair.
    """
    cells = rounds[0].size
    for shift in range(64):
        agreements = sum(int((a[shift:] == b[: cells - shift]).sum()) for a, b in zip(*[iter(rounds)] * 2, strict=True))
        if not is_binomial(agreements, len(rounds) // 2 * (cells - shift), 0.5):
            return False
    return True


def test_iid_rounds_are_independent() -> None:
    """The draws of successive rounds have nothing in common, also not shifted."""
    assert agreements_are_chance([flat(model("iid:0.5").losses(k)) for k in range(400)])


def test_overlapping_draws_are_noticed() -> None:
    """The test above fails if a round begins four draws (one block of Philox) after the one before."""
    stream = np.random.default_rng(3).random(2000) < 0.5
    assert not agreements_are_chance([stream[4 * k : 4 * k + 162] for k in range(400)])


def marks_are_chance(rounds: Sequence[np.ndarray]) -> bool:
    """Return whether fair marks of one round agree with each other as often as chance does, at every shift.

    At one shift, the pairs of marks form paths without a circle, so their agreements are independent and fair.
    """
    marks = np.array(rounds)
    return all(
        is_binomial(int((marks[:, shift:] == marks[:, :-shift]).sum()), marks[:, shift:].size, 0.5)
        for shift in range(1, marks.shape[1])
    )


def test_iid_marks_are_independent() -> None:
    """Within a round, losses and coins have nothing in common."""
    assert marks_are_chance([flat(model("iid:0.5").losses(k)) for k in range(400)])


def test_burst_coins_are_independent_of_the_states() -> None:
    """What a receiver decodes in a conflict has nothing to do with the change of its state, and is fair."""
    # with 0.5,0.5 a state changes by a fair draw
    drawn = model("burst:0.5,0.5")
    changed = np.diff(bad_states(drawn, 1001).astype(int), axis=0) != 0
    coins = np.array([flat(drawn.losses(k))[M * N + M * M + N * M :] for k in range(1, 1001)])
    assert all(is_binomial(int(count), 1000, 0.5) for count in coins.sum(axis=0))
    assert marks_are_chance(list(np.hstack([changed, coins])))


def test_draws_used_twice_are_noticed() -> None:
    """The tests above fail if coins are the draws of losses again."""
    rounds = np.random.default_rng(3).random((1000, 76)) < 0.5
    assert marks_are_chance(list(rounds))
    rounds[:, 30:] = rounds[:, :-30]
    assert not marks_are_chance(list(rounds))


def nested(fewer: LossModel, more: LossModel) -> bool:
    """Return whether all that the one loses is lost by the other, too."""
    return all(not (a & ~b).any() for a, b in zip(lost_cells(fewer, 50), lost_cells(more, 50), strict=True))


def test_iid_losses_grow_with_p() -> None:
    """With one seed, what is lost with some P is lost with every greater P; with another seed it is not."""
    models = [model(f"iid:{p}") for p in ("0", "0.01", "0.1", "0.5", "1")]
    assert all(nested(a, b) for a, b in pairwise(models))
    assert not nested(model("iid:0.1"), model("iid:0.5", seed=8))


def test_iid_extremes_are_exact() -> None:
    """P = 0 loses nothing and P = 1 everything, in every round."""
    for k in range(200):
        assert model("iid:0").losses(k).count == 0
        assert model("iid:1").losses(k).count == M * N + M * M + N * M


# --- burst ---------------------------------------------------------------------------------------------------------

ENTER, LEAVE, ROUNDS = 0.05, 0.4, 10_000


def bad_states(drawn: LossModel, rounds: int = ROUNDS) -> np.ndarray:
    """Return (rounds, receivers): whether each receiver, CUs first, loses everything; it must be that or nothing."""
    found = np.zeros((rounds, M + N), bool)
    for k in range(rounds):
        losses = drawn.losses(k)
        rows = [*np.hstack([losses.cu_uav, losses.cu_slot]), *losses.uav_slot]
        assert all(row.all() == row.any() for row in rows)
        found[k] = [row.all() for row in rows]
    return found


def has_stationary_share(bad: np.ndarray) -> bool:
    """Return whether the share of bad states is credible for a Gilbert-Elliott channel of ENTER and LEAVE.

    With s(k) the number of bad receivers, s(k) − s(k−1) = a (R − s(k−1)) − b s(k−1) + m(k), where m(k) is a sum of R
    martingale differences. Summing over K rounds, (a + b) Σs(k−1) = a R K − (s(K) − s(0)) + Σm(k): the share is
    a / (a + b) up to (R + |Σm|) / ((a + b) R K), and Freedman's inequality bounds |Σm|.
    """
    steps, receivers = len(bad) - 1, bad.shape[1]
    stray = deviation(steps * receivers * max(ENTER * (1 - ENTER), LEAVE * (1 - LEAVE)))
    share = bad[:-1].mean()
    return bool(abs(share - ENTER / (ENTER + LEAVE)) <= (receivers + stray) / ((ENTER + LEAVE) * receivers * steps))


def has_transitions(bad: np.ndarray) -> bool:
    """Return whether the numbers of steps from good to bad and from bad to good are credible for ENTER and LEAVE.

    Each is a sum of martingale differences (step or not, less its probability) over the rounds spent in the state.
    """
    before, after = bad[:-1], bad[1:]
    entered, left = int((~before & after).sum()), int((before & ~after).sum())
    return all(
        abs(count - p * visits) <= deviation(before.size * p * (1 - p))
        for count, p, visits in ((entered, ENTER, int((~before).sum())), (left, LEAVE, int(before.sum())))
    )


def test_burst_has_its_stationary_share_and_steps() -> None:
    """Receivers lose everything or nothing; the share of bad rounds and the steps are those of Gilbert and Elliott."""
    bad = bad_states(model(f"burst:{ENTER},{LEAVE}"))
    assert has_stationary_share(bad)
    assert has_transitions(bad)


def test_other_channels_are_noticed() -> None:
    """The test above fails for a channel with another LEAVE, with its numbers swapped, and for one without memory."""
    shorter = bad_states(model(f"burst:{ENTER},0.3"))
    assert not has_stationary_share(shorter)
    assert not has_transitions(shorter)
    assert not has_stationary_share(bad_states(model(f"burst:{LEAVE},{ENTER}"), 1000))
    memoryless = np.random.default_rng(5).random((ROUNDS, M + N)) < ENTER / (ENTER + LEAVE)
    assert has_stationary_share(memoryless)
    assert not has_transitions(memoryless)


def test_burst_receivers_are_independent() -> None:
    """Receivers do not enter the bad state together: of fair steps, those of any two agree as often as chance does."""
    # with 0.5,0.5 every state after round 0 is a fair coin
    bad = bad_states(model("burst:0.5,0.5"), 2000)[1:]
    for receiver in range(M + N - 1):
        assert is_binomial(int((bad[:, receiver] == bad[:, receiver + 1]).sum()), len(bad), 0.5)
    assert not is_binomial(len(bad), len(bad), 0.5)


def test_burst_extremes_are_exact() -> None:
    """Round 0 is good; 0,1 never loses, 1,0 always from round 1 on, 1,1 in every odd round."""
    expected = {"burst:0,1": [False] * 4, "burst:1,0": [False, True, True, True], "burst:1,1": [False, True] * 2}
    for spec, states in expected.items():
        assert [list(row) for row in bad_states(model(spec), 4)] == [[state] * (M + N) for state in states]


def test_a_late_round_may_be_asked_first() -> None:
    """A round of a burst, some of its receivers bad, is the same whether the rounds before were asked for or not."""
    asked = Burst(N, M, Fraction(1, 20), Fraction(2, 5), 7)
    late = next(k for k in range(500, 600) if asked.losses(k).count)
    assert same(asked.losses(late), model("burst:0.05,0.4").losses(late))


# --- jam -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("start", "rounds", "target_change", "jammed"),
    [
        (3, 5, 0, range(3, 8)),
        (3, 5, 20, range(23, 28)),
        (0, 1, 0, range(1)),
        (4, 0, 0, range(0)),
        (0, 2, 9, range(9, 11)),
    ],
)
def test_jam_window(start: int, rounds: int, target_change: int, jammed: range) -> None:
    """CUs hear nothing in exactly ROUNDS rounds from START after the target change; UAVs hear everything, always."""
    drawn = model(f"jam:{start},{rounds}", target_change=target_change)
    for k in range(40):
        losses = drawn.losses(k)
        assert losses.cu_uav.all() == losses.cu_uav.any() == (k in jammed)
        assert losses.cu_slot.all() == losses.cu_slot.any() == (k in jammed)
        assert not losses.uav_slot.any()
        assert not losses.replies_at_cus.any()
        assert not losses.replies_at_uavs.any()


def test_jam_takes_any_integer_for_a_round() -> None:
    """A round given as a numpy integer is the same round."""
    jam = Jam(N, M, 3, 5)
    assert [bool(jam.losses(k).count) for k in np.arange(10)] == [3 <= k < 8 for k in range(10)]  # type: ignore[arg-type]


# --- what cannot be parsed -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("spec", "says"),
    [
        ("", "there is no loss model '': choose none, iid:P, burst:P_ENTER,P_LEAVE, jam:START,ROUNDS, script:FILE"),
        ("nothing", "there is no loss model 'nothing': choose none, "),
        ("None", "there is no loss model 'None'"),
        ("none:", "there is no loss model 'none:'"),
        ("none:1", "there is no loss model 'none:1'"),
        ("iid", "there is no loss model 'iid': choose none, iid:P"),
        ("adversary:10", "'adversary:10' is a search for losses: it stands alone"),
        ("exhaustive:4", "'exhaustive:4' is a search for losses"),
        ("script", "there is no loss model 'script'"),
        ("script:", "there is no loss model 'script:'"),
        ("x" * 1000, "there is no loss model 'xxx"),
        ("iid:", "must have the form iid:P, such as iid:0.1"),
        ("iid:0,1", "must have the form iid:P"),
        ("iid:0.1,0.2", "must have the form iid:P"),
        ("burst:0.1", "must have the form burst:P_ENTER,P_LEAVE, such as burst:0.05,0.4"),
        ("burst:0.1,", "must have the form burst"),
        ("burst:0.1,0.2,0.3", "must have the form burst"),
        ("jam:5", "must have the form jam:START,ROUNDS, such as jam:5,10"),
        ("jam:5,6,7", "must have the form jam"),
        ("iid:nan", "P of the loss model 'iid:nan': 'nan' is not a number"),
        ("iid:inf", "'inf' is not a number"),
        ("iid:10%", "'10%' is not a number"),
        ("iid:1/0", "divides by zero"),
        ("iid:0x1", "is not a number"),
        ("iid:1e999999999", "out of range"),
        ("iid:" + "1" * 5000, "too long for a number"),
        ("iid:1.5", "P of the loss model 'iid:1.5' is a probability: it must be between 0 and 1"),
        ("iid:-0.1", "it must be between 0 and 1"),
        ("iid:1.000000000000000000001", "it must be between 0 and 1"),
        ("burst:2,0.1", "P_ENTER of the loss model 'burst:2,0.1' is a probability"),
        ("burst:0.1,-1", "P_LEAVE of the loss model 'burst:0.1,-1' is a probability"),
        ("burst:0.1,x", "P_LEAVE of the loss model 'burst:0.1,x': 'x' is not a number"),
        ("jam:-1,5", "START of the loss model 'jam:-1,5' must be a whole number of rounds, 0 to 999999999"),
        ("jam:5,-1", "ROUNDS of the loss model 'jam:5,-1' must be a whole number"),
        ("jam:1.5,2", "START of the loss model"),
        ("jam:5,nan", "ROUNDS of the loss model"),
        ("jam:1_0,2", "START of the loss model"),
        ("jam:٣,2", "START of the loss model"),
        ("jam:5," + "9" * 5000, "ROUNDS of the loss model"),
    ],
)
def test_bad_specs_are_told_in_one_sentence(spec: str, says: str) -> None:
    """A text that is no loss model is refused, with a sentence on one line that says what would be right."""
    with pytest.raises(BadInput) as refused:
        model(spec)
    text = str(refused.value)
    assert says in text
    assert "\n" not in text
    assert len(text) < 300


def test_a_negative_seed_is_refused() -> None:
    """A seed is not negative, whatever the model."""
    for spec in ("none", "iid:0.1"):
        with pytest.raises(BadInput, match="the seed must not be negative, as -1 is"):
            model(spec, seed=-1)


def test_every_form_has_an_example_that_works() -> None:
    """The examples given for the forms can be parsed (but for the script, which needs its file)."""
    for form, example in FORMS.items():
        assert form.partition(":")[0] == example.partition(":")[0]
        if not form.startswith("script"):
            model(example)


def test_spaces_around_numbers_do_not_matter() -> None:
    """Numbers may have spaces around them, and fractions are numbers."""
    assert same(model("iid: 1/10 ").losses(3), model("iid:0.1").losses(3))
    assert same(model("jam: 2 , 3 ").losses(4), model("jam:2,3").losses(4))
