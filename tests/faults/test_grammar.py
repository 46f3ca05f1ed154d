"""The grammar of losses: windows, links and sums mean what an independent reading says; near misses are put right."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from random import Random

import numpy as np
import pytest
from tests.faults.test_losses import arrays, same

from swarmproof.dmpc_swarm.protocol.deliver import deliver
from swarmproof.dmpc_swarm.protocol.messages import (
    CuMessage,
    EmptyMessage,
    Metadata,
    Trajectory,
    TrajectoryMessage,
    UavMessage,
)
from swarmproof.dmpc_swarm.protocol.network import Air, Reception, Slot
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.errors import BadInput
from swarmproof.faults import combine, grammar
from swarmproof.faults.combine import Links, Sum, Windowed
from swarmproof.faults.forms import COMBINED, FORMS
from swarmproof.faults.grammar import parse
from swarmproof.faults.losses import FOREVER, Burst, Iid, Jam, Losses, LossModel, TermModel
from swarmproof.faults.pattern import BySender

N, M, SEED, ROUNDS = 4, 3, 7, 14
RULES = [Semantics.parse("guarded", [f"slot_conflict={value}"]) for value in ("either", "both-lost", "cu-wins")]
EVERYBODY = [("cu", w) for w in range(M)] + [("uav", i) for i in range(N)]
Name = tuple[str, int]
Parse = Callable[[str, int, int, int], LossModel]

# An independent reading: message by message, receiver by receiver. Draws are those of models alone, which other tests
# check; everything else is done in another way than in the program.


@dataclass(frozen=True)
class Term:
    """A term: a model's text, or None for everything; both ends of a link with its arrow; first and last round."""

    model: str | None
    link: tuple[str, str, str] | None = None
    window: tuple[int, int | None] | None = None

    @property
    def text(self) -> str:
        """The term as somebody would write it."""
        head = "" if self.link is None else "".join(self.link)
        parts = [part for part in (head, self.model) if part]
        first, last = self.window or (0, None)
        when = f"@{first}" if first == last else f"@{first}-{'' if last is None else last}"
        return ":".join(parts) + ("" if self.window is None else when)

    def is_open(self, k: int) -> bool:
        """Say whether it is about round k."""
        first, last = self.window or (0, None)
        return k >= first and (last is None or k <= last)

    def is_about(self, sender: Name, receiver: Name) -> bool:
        """Say whether it is about what one sends to the other."""
        if self.link is None:
            return True
        one, arrow, other = self.link
        forth = named(one, sender) and named(other or "*", receiver)
        return forth or (arrow == "<->" and named(other, sender) and named(one, receiver))


def named(end: str, who: Name) -> bool:
    """Say whether one end of a link names somebody."""
    return end in ("*", f"{who[0]}*", f"{who[0]}{who[1]}")


def alone(terms: Sequence[Term], n: int) -> LossModel | None:
    """Return the model of a term as it is alone; the second one of a kind draws independently."""
    text = terms[n].model
    if text is None:
        return None
    kind, _, rest = text.partition(":")
    before = sum((term.model or "").startswith(f"{kind}:") for term in terms[:n])
    values = [Fraction(value) for value in rest.split(",") if value]
    if kind == "iid":
        return Iid(N, M, values[0], SEED, before)
    if kind == "burst":
        return Burst(N, M, values[0], values[1], SEED, before)
    return parse(text, N, M, SEED)


class Reading:
    """What a sum of terms means in round k."""

    def __init__(self, terms: Sequence[Term], k: int) -> None:
        self.open = [
            (term, None if model is None else model.losses(k))
            for term, model in ((term, alone(terms, n)) for n, term in enumerate(terms))
            if term.is_open(k)
        ]

    def is_lost(self, sender: Name, receiver: Name, slot: int | None) -> bool:
        """Say whether a message is lost on its way: one in a slot, or metadata."""
        for term, drawn in self.open:
            if not term.is_about(sender, receiver):
                continue
            if drawn is None:
                return True
            if slot is None:
                marked = drawn.cu_uav[receiver[1], sender[1]]
            else:
                marked = (drawn.cu_slot if receiver[0] == "cu" else drawn.uav_slot)[receiver[1], slot]
            if marked:
                return True
        return False

    def decodes_reply(self, receiver: Name, slot: int) -> bool:
        """Say which of two messages a receiver decodes that could hear either."""
        for term, drawn in self.open:
            if drawn is not None and term.model is not None and term.model.startswith(("iid", "burst")):
                coins = drawn.replies_at_cus if receiver[0] == "cu" else drawn.replies_at_uavs
                return bool(coins[receiver[1], slot])
        return False

    def hears(self, receiver: Name, slot: int, on_slot: Slot, conflict: str) -> object:
        """Return what a receiver hears in a slot: a message or None, and whether something was lost."""
        sent: list[tuple[Name, object]] = []
        if on_slot.cu_message is not None:
            sent.append((("cu", slot), on_slot.cu_message))
        if on_slot.reply is not None:
            sent.append((("uav", on_slot.reply.uav), on_slot.reply))
        own = [message for sender, message in sent if sender == receiver]
        if receiver[0] == "cu" and own:
            return own[0], False
        if (own and (len(sent) == 1 or conflict != "cu-wins")) or not sent:
            return None, False
        if len(sent) == 2 and conflict == "both-lost":
            return None, False
        if len(sent) == 2 and conflict == "cu-wins":
            sent = sent[:1]
        arriving = [message for sender, message in sent if not self.is_lost(sender, receiver, slot)]
        if not arriving:
            return None, True
        if len(arriving) == 1:
            return arriving[0], False
        return arriving[1 if self.decodes_reply(receiver, slot) else 0], False

    def reception(self, receiver: Name, air: Air, conflict: str) -> tuple[object, ...]:
        """Return what a receiver gets of a round: metadata by UAV (of a CU), and each slot."""
        metadata = tuple(receiver[0] == "uav" or not self.is_lost(("uav", i), receiver, None) for i in range(N))
        return metadata, tuple(self.hears(receiver, s, on_slot, conflict) for s, on_slot in enumerate(air.slots))


def told(got: Reception) -> tuple[object, ...]:
    """Return a reception in the form above."""
    metadata = tuple(i not in got.lost_uavs for i in range(N))
    return metadata, tuple((got.inbox.cu_messages.get(s), s in got.lost_slots) for s in range(M))


def airs(rounds: int) -> Iterator[Air]:
    """Yield what is transmitted in some rounds: any message or none of each CU, and replies in half of the slots."""
    rng = np.random.default_rng(11)
    for k in range(rounds):
        slots = []
        for w in range(M):
            messages: list[CuMessage | None] = [
                None,
                EmptyMessage(),
                TrajectoryMessage(int(rng.integers(N)), Trajectory(Metadata(k, w))),
            ]
            uav = int(rng.integers(N))
            reply = TrajectoryMessage(uav, Trajectory(Metadata(k - 3, uav)))
            slots.append(Slot(messages[rng.integers(3)], reply if rng.integers(2) else None))
        yield Air(tuple(UavMessage(Metadata(k, i)) for i in range(N)), tuple(slots))


def sums(count: int) -> Iterator[list[Term]]:
    """Yield sums of one to three terms of every kind."""
    random = Random(5)
    ends = ["*", "cu*", "uav*", "cu0", "cu2", "uav0", "uav3"]
    models = ["iid:0.5", "iid:1/3", "burst:0.3,0.4", "jam:3,5", "none", None]
    for _ in range(count):
        terms = []
        for _ in range(random.choice([1, 1, 2, 3])):
            arrow = random.choice(["", "->", "<->"])
            link = (random.choice(ends), arrow, random.choice(ends) if arrow else "")
            model = random.choice(models)
            first = random.randrange(10)
            window = (first, random.choice([None, first, first + random.randrange(5)]))
            terms.append(
                Term(
                    model,
                    link if model is None or (random.random() < 0.6 and model != "none") else None,
                    window if random.random() < 0.6 else None,
                )
            )
        yield terms


def agree(read: Parse, cases: Sequence[Sequence[Term]]) -> bool:
    """Return whether texts mean the same, read by the program and as above, in every round and at every receiver."""
    for terms in cases:
        losses = read("+".join(term.text for term in terms), N, M, SEED)
        for k, air in enumerate(airs(ROUNDS)):
            reading = Reading(terms, k)
            for rules in RULES:
                at_cus, at_uavs = deliver(air, losses.losses(k), rules)
                for receiver, got in zip(EVERYBODY, (*at_cus, *at_uavs), strict=True):
                    if told(got) != reading.reception(receiver, air, rules.slot_conflict):
                        return False
    return True


CASES = list(sums(80))
#: A few sums in which each of the planted bugs below shows.
TELLING = [
    [Term(None, ("uav3", "", ""), (2, 9))],
    [Term("iid:0.5", ("cu2", "->", "uav*"), (5, None)), Term("jam:3,5")],
    [Term("burst:0.3,0.4"), Term("iid:1/3", None, (4, 4))],
    [Term("iid:0.5"), Term("iid:0.5", None, (0, 20))],
    [Term(None, ("uav0", "<->", "cu0"))],
]


def test_losses_mean_what_an_independent_reading_says() -> None:
    """Eighty sums of models, links and windows: everybody receives what the reading above says, in every round."""
    assert agree(parse, CASES)
    assert agree(parse, TELLING)


# Planted bugs: the comparison fails for each.


def _window_too_short(monkeypatch: pytest.MonkeyPatch) -> None:
    def windowed(model: TermModel, window: range, uavs: int, cus: int) -> Windowed:
        return Windowed(model, range(window.start, window.stop - 1), uavs, cus)

    monkeypatch.setattr(grammar, "Windowed", windowed)


def _window_too_late(monkeypatch: pytest.MonkeyPatch) -> None:
    def windowed(model: TermModel, window: range, uavs: int, cus: int) -> Windowed:
        return Windowed(model, range(window.start + 1, window.stop), uavs, cus)

    monkeypatch.setattr(grammar, "Windowed", windowed)


def _window_draws_from_its_start(monkeypatch: pytest.MonkeyPatch) -> None:
    class Shifted(Windowed):
        def losses(self, k: int) -> Losses:
            return self._model.losses(k - self._window.start) if self._is_open(k) else self._outside

    monkeypatch.setattr(grammar, "Windowed", Shifted)


def _only_the_first_term(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grammar, "Sum", lambda terms, uavs, cus: Sum(terms[:1], uavs, cus))


def _lost_by_every_term(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(combine, "_any", lambda all_: np.logical_and.reduce(all_))


def _same_draws_for_all_terms(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(grammar._Numbers, "nth", lambda self, kind: 0)


def _coins_of_the_last_term(monkeypatch: pytest.MonkeyPatch) -> None:
    class Last(Sum):
        def losses(self, k: int) -> Losses:
            mine, last = super().losses(k), self._terms[-1].losses(k)
            return Losses(*arrays(mine)[:3], *arrays(last)[3:], by_sender=mine.by_sender)

    monkeypatch.setattr(grammar, "Sum", Last)


def _silent_is_deaf(monkeypatch: pytest.MonkeyPatch) -> None:
    read = Links.read

    def turned(text: str, uavs: int, cus: int) -> Links | None:
        found = read(text, uavs, cus)
        if found is None:
            return None
        links = np.hstack([found.from_cus, found.from_uavs]).T
        return Links(links[:, cus:], links[:, :cus])

    monkeypatch.setattr(Links, "read", staticmethod(turned))


def _silent_uavs_reply(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(combine, "BySender", lambda cus, uavs: BySender(cus, np.zeros_like(uavs)))


def _replies_of_silent_cus_slots_are_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    def by_slot(of_cus: np.ndarray, of_uavs: np.ndarray) -> BySender:
        return BySender(of_cus, of_uavs | of_cus[:, :, np.newaxis])

    monkeypatch.setattr(combine, "BySender", by_slot)


def _both_ways_is_one_way(monkeypatch: pytest.MonkeyPatch) -> None:
    read = Links.read
    monkeypatch.setattr(Links, "read", staticmethod(lambda text, uavs, cus: read(text.replace("<->", "->"), uavs, cus)))


@pytest.mark.parametrize(
    "plant",
    [
        _window_too_short,
        _window_too_late,
        _window_draws_from_its_start,
        _only_the_first_term,
        _lost_by_every_term,
        _same_draws_for_all_terms,
        _coins_of_the_last_term,
        _silent_is_deaf,
        _silent_uavs_reply,
        _replies_of_silent_cus_slots_are_lost,
        _both_ways_is_one_way,
    ],
)
def test_planted_bugs_are_noticed(plant: Callable[[pytest.MonkeyPatch], None], monkeypatch: pytest.MonkeyPatch) -> None:
    """The comparison fails if windows, sums or links are read in another way."""
    plant(monkeypatch)
    assert not agree(parse, TELLING)


# Old forms


@pytest.mark.parametrize(
    ("spec", "model"),
    [
        ("iid:0.1", Iid(N, M, Fraction(1, 10), SEED)),
        ("iid:+1e-1", Iid(N, M, Fraction(1, 10), SEED)),
        ("iid:1e+0", Iid(N, M, Fraction(1), SEED)),
        ("burst:0.05,+0.4", Burst(N, M, Fraction(1, 20), Fraction(2, 5), SEED)),
        ("jam:3,5", Jam(N, M, 3, 5)),
    ],
)
def test_a_model_alone_is_the_model(spec: str, model: LossModel) -> None:
    """What was written before there was a grammar is the same model, also where a number has a plus sign."""
    read = parse(spec, N, M, SEED)
    assert type(read.model) is type(model)
    assert all(same(read.losses(k), model.losses(k)) for k in range(30))


@pytest.mark.parametrize("spec", ["iid:0.3", "burst:0.3,0.4", "jam:3,5"])
def test_windows_change_nothing_inside(spec: str) -> None:
    """Within a window, everything lost or decoded is as without; outside, everything arrives."""
    whole, part = parse(spec, N, M, SEED), parse(f"{spec}@4-6", N, M, SEED)
    for k in range(20):
        if 4 <= k <= 6:
            assert same(part.losses(k), whole.losses(k))
        else:
            assert not any(array.any() for array in arrays(part.losses(k)))


def test_two_terms_of_a_kind_are_independent() -> None:
    """Of iid:0.5+iid:0.5, three quarters of all pairs are lost, up to what 24,000 draws allow (10 sigma)."""
    lost = parse("iid:0.5+iid:0.5", N, M, SEED)
    pairs = M * N + M * M + N * M
    share = sum(lost.losses(k).count for k in range(800)) / (800 * pairs)
    assert abs(share - 0.75) < 10 * (0.75 * 0.25 / (800 * pairs)) ** 0.5
    assert abs(sum(parse("iid:0.5", N, M, SEED).losses(k).count for k in range(800)) / (800 * pairs) - 0.5) < 0.03


def test_spaces_do_not_matter() -> None:
    """Spaces around terms, links and windows do not matter."""
    one, other = parse(" cu0 -> uav* : iid:0.5 @ 3-9 + jam:3, 4", N, M, SEED), "cu0->uav*:iid:0.5@3-9+jam:3,4"
    again = parse(other, N, M, SEED)
    for k in range(12):
        mine, theirs = one.losses(k), again.losses(k)
        assert same(mine, theirs)
        assert (mine.by_sender is not None) == (theirs.by_sender is not None) == (3 <= k <= 9)
        if mine.by_sender is None or theirs.by_sender is None:
            continue
        assert np.array_equal(mine.by_sender.of_cus, theirs.by_sender.of_cus)
        assert np.array_equal(mine.by_sender.of_uavs, theirs.by_sender.of_uavs)


def test_every_form_has_an_example_that_is_read() -> None:
    """The examples of what can be made of models can be read."""
    for example, meaning in COMBINED.values():
        assert meaning
        parse(example, N, M, SEED)
    assert set(FORMS) <= {"none", "iid:P", "burst:P_ENTER,P_LEAVE", "jam:START,ROUNDS", "script:FILE"}


def test_the_documents_show_losses_that_are_read(tmp_path: Path) -> None:
    """Each loss that docs/flying.md quotes can be read, those of its commands and its script, too."""
    text = (Path(__file__).parents[2] / "docs/flying.md").read_text(encoding="utf-8")
    quoted = [loss for loss in re.findall(r"'([^'\n]+)'", text) if re.search(r"[:@>]", loss)]
    assert len(quoted) > 8
    for loss in quoted:
        parse(loss, N, M, SEED)
    (example,) = re.findall(r'^    (\{"schema".*?\})\n\n', text, re.MULTILINE | re.DOTALL)
    (tmp_path / "losses.json").write_text(example, encoding="utf-8")
    lost = parse(f"script:{tmp_path / 'losses.json'}", 2, 2, SEED)
    assert [lost.losses(k).count for k in (2, 3, 4, 5, 59, 60, 69, 70, 9999)] == [0, 1, 0, 4, 4, 0, 0, 6, 6]


# Files whose names look like grammar


def test_files_may_be_called_anything(tmp_path: Path) -> None:
    """A script's name may have + and @ in it; a file of the whole name is meant if it is there."""
    content = {"schema": "swarmproof.losses/1", "uavs": N, "cus": M, "rounds": {"3": [["cu 0", "uav 1"]]}}
    for name in ("a+b.json", "a@b.json", "a@5", "c+iid:1", "e+2.json"):
        (tmp_path / name).write_text(json.dumps(content), encoding="utf-8")
        lost = parse(f"script:{tmp_path / name}", N, M, SEED)
        assert [k for k in range(9) if lost.losses(k).count] == [3]
        if name in ("a@5", "c+iid:1"):  # within something longer, that is a window, and a term
            continue
        lost = parse(f"script:{tmp_path / name}@4-+jam:6,2", N, M, SEED)
        assert [k for k in range(9) if lost.losses(k).count] == [6, 7]
        lost = parse(f"jam:6,2+script:{tmp_path / name}@3", N, M, SEED)
        assert [k for k in range(9) if lost.losses(k).count] == [3, 6, 7]
    lost = parse(f"cu1->*:script:{tmp_path / 'a+b.json'}", N, M, SEED)
    assert not lost.losses(3).count


# What cannot be


@pytest.mark.parametrize(
    ("spec", "says"),
    [
        ("iid:0.2,300,115000", "write iid:0.2@300-115000"),
        ("iid:0.2,300", "write iid:0.2@300-"),
        ("burst:0.1,0.2,5,9", "write burst:0.1,0.2@5-9"),
        ("iid:0.2@300,115000", "write iid:0.2@300-115000"),
        ("iid:0.2@300:115000", "write iid:0.2@300-115000"),
        ("iid:0.2@300..115000", "write iid:0.2@300-115000"),
        ("iid:0.2@9-5", "ends before it begins: write iid:0.2@5-9"),
        ("iid:0.2@", "is no window of rounds: write iid:0.2@5-, or iid:0.2@5-20"),
        ("iid:0.2@-5", "is no window of rounds"),
        ("iid:0.2@5-x", "is no window of rounds"),
        ("iid:0.2@5@6", "P of the loss model 'iid:0.2@5'"),
        ("iid:10%", "10% is 0.1"),
        ("burst:5%,0.4", "5% is 0.05"),
        ("iid:0.1,jam:3,10", "a sum is written with +: iid:0.1+jam:3,10"),
        ("iid:0.1+", "has an empty term: write sums like iid:0.1+jam:3,10"),
        ("+iid:0.1", "has an empty term"),
        ("iid:0.1++jam:3,4", "has an empty term"),
        ("iid:0.1+jom:3,4", "there is no loss model 'jom:3,4': choose none, iid:P"),
        ("iid:0.1+jam:3", "the loss model 'jam:3' must have the form jam:START,ROUNDS"),
        ("cu0->uav*:0.2", "write cu0->uav*:iid:0.2"),
        ("uav1:", "there is no loss model ''"),
        ("uav1:jam:3", "the loss model 'jam:3' must have the form"),
        ("uav4", "there is no uav4: the last one is uav3"),
        ("cu0->cu3", "there is no cu3: the last one is cu2"),
        ("cu0-", "is no link: write cu0->uav*, *->cu1 or uav2, in quotes"),
        ("uav", "is no link"),
        ("cu0->drone1", "is no link"),
        ("drone1", "or a link such as cu0->uav*"),
        ("delay:1", "are faults, for which there is no word yet"),
        ("duplicate:0.1", "are faults"),
        ("iid:0.1+join:3", "are faults"),
        ("iid:0.1+adversary:10", "'adversary:10' is a search for losses: it stands alone"),
        ("uav1:exhaustive:3@5-", "is a search for losses"),
        ("iid:0.1+" * 2000 + "none", "is too long: at most 10000 characters"),
    ],
)
def test_near_misses_get_the_right_form(spec: str, says: str) -> None:
    """What is no loss is refused in one sentence, with what would be right."""
    with pytest.raises(BadInput) as refused:
        parse(spec, N, M, SEED)
    text = str(refused.value)
    assert says.removeprefix("write ") in text
    assert "\n" not in text
    assert len(text) < 400


# Losses without effect


@pytest.mark.parametrize(
    ("spec", "lost", "says"),
    [
        ("none", 0, []),
        ("iid:0.1", 3, []),
        ("iid:0.1+jam:3,4", 3, []),
        ("iid:0.1@59", 3, []),
        (
            "iid:0.2@60-",
            0,
            ["--loss iid:0.2@60- was asked for (iid:0.2@60- begins in round 60, the last round was 59)."],
        ),
        ("iid:0", 0, ["although --loss iid:0 was asked for (iid:0 never loses anything)."]),
        ("burst:0,1", 0, ["(burst:0,1 never loses anything)"]),
        ("jam:5,0", 0, ["(jam:5,0 never loses anything)"]),
        ("jam:3,4@7-", 0, ["(jam:3,4@7- never loses anything)"]),
        ("burst:1,1@0", 0, ["never loses anything"]),
        ("none@3-", 0, ["never loses anything"]),
        ("iid:1e-12", 0, ["Nothing was lost in these 60 rounds, although --loss iid:1e-12 was asked for."]),
        ("iid:0.1+jam:60,4", 9, ["Nothing was lost by jam:60,4: jam:60,4 begins in round 60, the last round was 59."]),
        ("iid:0.1+uav1@0-9", 9, []),
        ("uav1@60-+iid:0", 0, ["(uav1@60- begins in round 60, the last round was 59; iid:0 never loses anything)"]),
    ],
)
def test_losses_without_effect_are_told(spec: str, lost: int, says: list[str]) -> None:
    """What was asked for and lost nothing in 60 rounds is told; what did lose something, and `none`, is not."""
    found = parse(spec, N, M, SEED).without_effect(60, lost)
    assert len(found) == len(says)
    for line, what in zip(found, says, strict=True):
        assert what in line
        assert line.endswith(".")


def test_a_term_said_to_be_idle_loses_nothing() -> None:
    """Outside of the rounds that a term is said to be about, it marks nothing; most terms mark both of their ends."""
    ends = 0
    for terms in CASES:
        for term in terms:
            model = alone([term], 0)
            read = parse(term.text, N, M, SEED)
            span = read.terms[0].model.span
            marked = [k for k in range(30) if marks(read.losses(k))]
            assert all(k in span for k in marked), term.text
            if model is None and marked:
                assert span.start == marked[0]
                assert span.stop in (marked[-1] + 1, FOREVER, FOREVER + 1)
                ends += 1
    assert ends > 10


def marks(losses: Losses) -> bool:
    """Return whether anything is marked as lost."""
    by = losses.by_sender
    return bool(losses.count or (by is not None and (by.of_cus.any() or by.of_uavs.any())))
