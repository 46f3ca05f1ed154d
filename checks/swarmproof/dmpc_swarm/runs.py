"""Random runs of the readable model, at sizes that exploration cannot reach: drawn, checked and shrunk by Hypothesis.

A run is drawn as a list of :class:`Stretch`es, which mean something in every state: a CU does what a stretch wishes if
it may, and what is not sent cannot be lost. So dropping a stretch, a loss or a wish always leaves a run, and
Hypothesis shrinks a failing run to few rounds with few losses in which the CUs do nothing that does not matter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from functools import cache
from itertools import product

from hypothesis import strategies as st
from hypothesis.vendor.pretty import RepresentationPrinter

from swarmproof.dmpc_swarm.claims.protocol import CLAIMS, ProtocolClaim
from swarmproof.dmpc_swarm.observe import observe
from swarmproof.dmpc_swarm.protocol import algorithm1
from swarmproof.dmpc_swarm.protocol.algorithm1 import Decision
from swarmproof.dmpc_swarm.protocol.messages import Trajectory
from swarmproof.dmpc_swarm.protocol.network import Reception, receive_at_cu, receive_at_uav
from swarmproof.dmpc_swarm.protocol.swarm import Events, Swarm, compute, initial_swarm, step
from swarmproof.dmpc_swarm.protocol.uav import Uav, offers
from swarmproof.dmpc_swarm.semantics import SWITCHES, Semantics
from swarmproof.dmpc_swarm.system import swarm
from swarmproof.errors import BadInput
from swarmproof.falsify.walks import Breach, explain, first_breach
from swarmproof.system import Scope
from swarmproof.trace.trace import Trace, record

#: The sizes up to which runs are drawn unless told otherwise.
MOST_UAVS, MOST_CUS = 6, 4
#: The most rounds of a run unless told otherwise: enough to lose everything and to recover twice.
MOST_ROUNDS = 60

#: By receiver, some of what is sent: slots of CUs, or UAVs.
_ByReceiver = Mapping[int, AbstractSet[int]]


@dataclass(frozen=True, slots=True)
class Stretch:
    """Some rounds in which the CUs wish the same; messages are lost in the last of them only.

    Attributes:
        rounds: how many.
        wishes: by CU, the UAV that it plans or asks if it may; else it does the first thing that is left open to it.
        uavs_lost_at_cus: by CU, the UAVs whose metadata it misses.
        slots_lost_at_cus: by CU, the slots whose message it misses.
        slots_lost_at_uavs: by UAV, the slots whose message it misses.
        decoded_at_cus: by CU, the slots of which it decodes the reply if there is a conflict.
        decoded_at_uavs: by UAV, the same.
        preferred: by UAV, the CU whose trajectory it follows if it is offered several.
    """

    rounds: int = 1
    wishes: Mapping[int, int] = field(default_factory=dict)
    uavs_lost_at_cus: _ByReceiver = field(default_factory=dict)
    slots_lost_at_cus: _ByReceiver = field(default_factory=dict)
    slots_lost_at_uavs: _ByReceiver = field(default_factory=dict)
    decoded_at_cus: _ByReceiver = field(default_factory=dict)
    decoded_at_uavs: _ByReceiver = field(default_factory=dict)
    preferred: Mapping[int, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Run:
    """A run of the model: in round k, `swarms[k]` is the swarm in the computation phase, `events[k]` what happens."""

    uavs: int
    cus: int
    semantics: Semantics
    swarms: tuple[Swarm, ...]
    events: tuple[Events, ...]

    def trace(self, shows: str, rounds: int | None = None) -> Trace:
        """Write down the run, or its first `rounds`, as a trace that shows the claim or witness with id `shows`."""
        return record(self.scope, shows, self.events[:rounds])

    @property
    def scope(self) -> Scope:
        """What the run is of; it may be larger than what can be explored."""
        return swarm(self.uavs, self.cus, self.semantics)

    def __repr__(self) -> str:
        """Say how large the run is; its trace says the rest."""
        lost = sum(events.lost for events in self.events)
        return (
            f"<run of {self.uavs} UAVs and {self.cus} CUs under {self.semantics.name()}: "
            f"{len(self.events)} rounds, {lost} messages lost>"
        )

    def _repr_pretty_(self, printer: RepresentationPrinter, cycle: bool) -> None:
        """Let Hypothesis print the same."""
        printer.text(repr(self))


def perform(uavs: int, cus: int, semantics: Semantics, stretches: Sequence[Stretch], max_rounds: int) -> Run:
    """Return the run of the readable model that these stretches make, cut off after `max_rounds`."""
    swarms = [initial_swarm(uavs, cus, semantics)]
    happened: list[Events] = []
    for stretch in stretches:
        for left in range(stretch.rounds, 0, -1):
            if len(happened) == max_rounds:
                break
            events = _events(swarms[-1], stretch, left == 1, semantics)
            happened.append(events)
            swarms.append(step(swarms[-1], events, semantics))
    return Run(uavs, cus, semantics, tuple(swarms), tuple(happened))


def _events(swarm: Swarm, stretch: Stretch, lossy: bool, semantics: Semantics) -> Events:
    decided = _decide(swarm, stretch.wishes, semantics)
    _, air = compute(swarm, decided, semantics)

    def lost(at: _ByReceiver, receiver: int) -> AbstractSet[int]:
        return at.get(receiver, frozenset()) if lossy else frozenset()

    at_cus = tuple(
        receive_at_cu(
            cu.w,
            air,
            lost(stretch.uavs_lost_at_cus, cu.w),
            lost(stretch.slots_lost_at_cus, cu.w),
            stretch.decoded_at_cus.get(cu.w, frozenset()),
            semantics,
        )
        for cu in swarm.cus
    )
    at_uavs = tuple(
        receive_at_uav(
            uav.i,
            air,
            lost(stretch.slots_lost_at_uavs, uav.i),
            stretch.decoded_at_uavs.get(uav.i, frozenset()),
            semantics,
        )
        for uav in swarm.uavs
    )
    adopted = tuple(_adopt(uav, got, stretch.preferred) for uav, got in zip(swarm.uavs, at_uavs, strict=True))
    return Events(decided, at_cus, at_uavs, adopted)


def _decide(swarm: Swarm, wishes: Mapping[int, int], semantics: Semantics) -> tuple[Decision, ...]:
    """Let each CU do what it is wished to, or else the first of what the algorithm and the CUs before it leave open."""
    taken: set[Decision] = set()
    decided = []
    for cu in swarm.cus:
        options = [
            (decision, exclusive)
            for decision in algorithm1.decisions(cu, swarm.k, len(swarm.cus), semantics)
            if not (exclusive := algorithm1.is_exclusive(cu, decision, semantics)) or decision not in taken
        ]
        wished = [option for option in options if cu.w in wishes and option[0] == wishes[cu.w]]
        decision, exclusive = (wished or options)[0]
        if exclusive:
            taken.add(decision)
        decided.append(decision)
    return tuple(decided)


def _adopt(uav: Uav, got: Reception, preferred: Mapping[int, int]) -> Trajectory | None:
    offered = offers(uav, got.inbox)
    wished = [new for new in offered if new.metadata.cu == preferred.get(uav.i)]
    return next(iter(wished or offered), None)


@cache
def stretches(uavs: int, cus: int, semantics: Semantics) -> st.SearchStrategy[Stretch]:
    """Draw a stretch: some rounds without any loss, and one in which often nothing, or little, or much is lost."""
    conflicts = semantics.slot_conflict == "either"
    drawn = st.builds(
        Stretch,
        rounds=st.integers(1, 2 * uavs + 4),  # more than it takes to recover
        wishes=st.dictionaries(_below(cus), _below(uavs), max_size=cus),
        uavs_lost_at_cus=_some(cus, uavs),
        slots_lost_at_cus=_some(cus, cus),
        slots_lost_at_uavs=_some(uavs, cus),
        decoded_at_cus=_some(cus, cus) if conflicts else st.just({}),
        decoded_at_uavs=_some(uavs, cus) if conflicts else st.just({}),
        preferred=st.just({}) | st.dictionaries(_below(uavs), _below(cus), max_size=uavs),
    )
    return st.one_of(st.just(Stretch()), drawn, drawn, drawn)  # the first one, since Hypothesis drops small things best


def _below(size: int) -> st.SearchStrategy[int]:
    return st.integers(0, size - 1)


def _some(receivers: int, senders: int) -> st.SearchStrategy[_ByReceiver]:
    """Draw what is lost (or decoded) at whom: half of the time nothing; sometimes a receiver is deaf to all senders."""
    any_of_them = st.tuples(*[st.booleans()] * senders).map(
        lambda chosen: frozenset(sender for sender, is_chosen in enumerate(chosen) if is_chosen)
    )
    return st.just({}) | st.dictionaries(_below(receivers), any_of_them, max_size=receivers)


def runs(
    uavs: int, cus: int, semantics: Semantics, max_rounds: int = MOST_ROUNDS, max_stretches: int = 12
) -> st.SearchStrategy[Run]:
    """Draw runs of one swarm, of at most `max_rounds` rounds.

    Any run of the model can be drawn as long as it has at most `max_stretches` rounds; longer ones have stretches in
    which nothing is lost.

    Args:
        uavs: N.
        cus: M.
        semantics: the reading of the paper.
        max_rounds: where runs are cut off.
        max_stretches: how often the wishes may change and messages may be lost.

    Raises:
        BadInput: there are no such swarms.
    """
    if uavs < 1 or cus < 1 or max_rounds < 0:
        raise BadInput(f"{uavs} UAVs and {cus} CUs have no runs of {max_rounds} rounds: choose at least 1, 1 and 0")
    drawn = st.lists(stretches(uavs, cus, semantics), max_size=max_stretches)
    return _performed(drawn, uavs, cus, semantics, max_rounds)


@st.composite
def _performed(
    draw: st.DrawFn,
    drawn: st.SearchStrategy[list[Stretch]],
    uavs: int,
    cus: int,
    semantics: Semantics,
    max_rounds: int,
) -> Run:
    """Do what `drawn.map(perform)` does, without Hypothesis' printing all that went into a run."""
    return perform(uavs, cus, semantics, draw(drawn), max_rounds)


def readings(fixed: Mapping[str, str] | None = None) -> st.SearchStrategy[Semantics]:
    """Draw semantics in which the switches of `fixed` have these values, and the others any; the defaults come first.

    Raises:
        BadInput: there is no such switch or value, or these values exclude each other.
    """
    fixed = dict(fixed or {})
    values = [(fixed[name],) if name in fixed else SWITCHES[name] for name in SWITCHES]
    possible = []
    for chosen in product(*values):
        try:
            possible.append(Semantics.from_values(dict(zip(SWITCHES, chosen, strict=True)) | fixed))
        except BadInput as excluded:
            reason = excluded
    if not possible:
        raise reason
    return st.sampled_from(possible)


def runs_of_any_size(
    semantics: st.SearchStrategy[Semantics],
    max_uavs: int = MOST_UAVS,
    max_cus: int = MOST_CUS,
    max_rounds: int = MOST_ROUNDS,
) -> st.SearchStrategy[Run]:
    """Draw runs of swarms of 1 to `max_uavs` UAVs and 1 to `max_cus` CUs under the semantics that are drawn."""
    return st.tuples(st.integers(1, max_uavs), st.integers(1, max_cus), semantics).flatmap(
        lambda scope: runs(*scope, max_rounds=max_rounds)
    )


def check_run(run: Run, claims: Sequence[ProtocolClaim] = CLAIMS) -> Breach | None:
    """Return the first state of a run in which a safety claim is false; None if all that apply are true in all."""
    return first_breach(run.swarms, observe, [claim for claim in claims if claim.applies_to(run.semantics)])


def run_property(run: Run, claims: Sequence[ProtocolClaim] = CLAIMS) -> None:
    """Assert that the safety claims are true in every state of a run: the body of a Hypothesis test.

    Args:
        run: drawn by :func:`runs` or :func:`runs_of_any_size`.
        claims: of which those are checked that are safety claims and apply to the run's semantics.

    Raises:
        AssertionError: a claim is false; the message has its id, the broken places, and the run so far as a trace,
            which `swarmproof replay` reads from a file.
    """
    breach = check_run(run, claims)
    if breach is not None:
        raise AssertionError(explain(run.scope, run.events, breach))
