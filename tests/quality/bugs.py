"""The planted bugs: one changed line each, and the claims that must notice it.

The base is the semantics `guarded` with two UAVs and two CUs, where every claim holds. It is explored with
Abstraction.COUNTED: that of ESSENTIAL rests on lines 5-7 of Algorithm 2, which are among the lines that are changed.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from tests.quality.planting import Edit

from swarmproof.dmpc_swarm.protocol import algorithm1, algorithm2, event_trigger, uav
from swarmproof.dmpc_swarm.symmetry import Abstraction

#: (rounds, lost messages) of the shortest run; None for a goal that is never reached, which no run can show.
Caught = tuple[int, int] | None

#: States of the base without a bug, under COUNTED, and with the round-robin trigger under ESSENTIAL.
BASE_STATES = 22451
BASE_STATES_ROUND_ROBIN = 8059


@dataclass(frozen=True)
class Bug:
    """A bug, and what is found with it.

    Attributes:
        caught: every claim that is violated, with the length and the losses of its shortest counterexample.
        states: the reachable states; None where `max_states` ends the search before the fixpoint.
        worst_rounds: of a recovery that holds: the worst number of rounds (without any bug: 9).
        undecided: the claims that a search ended by `max_states` says nothing about.
        slow: whether it is left to the deep sweep.
    """

    name: str
    edit: Edit
    states: int | None
    caught: dict[str, Caught] = field(default_factory=dict)
    worst_rounds: int | None = None
    overrides: tuple[str, ...] = ()
    abstraction: Abstraction = Abstraction.COUNTED
    max_states: int | None = None
    undecided: tuple[str, ...] = ()
    slow: bool = False


def _all_of(rounds: int, lost: int) -> dict[str, Caught]:
    """Return the three claims about what trackers hold, all broken by runs of the same length."""
    return dict.fromkeys(("lemma-1", "lemma-2", "plans-from-truth"), (rounds, lost))


_LINE_4 = "for trajectory in trackers[i].trajectories:"
_LINE_5 = "if trajectory.metadata == uav_message.metadata:"
_LINE_13 = "deprecated = [old or new for old, new in zip(deprecated, marked, strict=True)]"
_LINE_17 = "incomplete = len(cu_messages) != cus"
_LINE_18 = "deprecated = [True] * len(d)  # line 18"
_LINE_22 = "d[message.uav] = _union(d[message.uav], message.trajectory)"
_LINE_9 = "if not any(tracker.deprecated for tracker in trackers) and may_rejoin:"
_LINE_10 = "state = CuState.WAIT  # line 10"
_LINES_23_24 = "return replace(cu, state=CuState.REQUEST_TRAJECTORY), EmptyMessage(prios)"
_LINE_28 = "asked = replace(cu, state=CuState.WAIT_FOR_UPDATE)"
_LINES_29_31 = "return replace(cu, state=CuState.REQUEST_TRAJECTORY), None"
_EQ_10 = "uav.followed if adopted is None else adopted"
_POSITION = "position = (k + w) % cus"

_NEVER_RUNS: dict[str, Caught] = {"can-plan": None}


def _algorithm_2(old: str, new: str) -> Edit:
    return Edit(algorithm2, old, new)


def _algorithm_1(old: str, new: str) -> Edit:
    return Edit(algorithm1, old, new)


CAUGHT: tuple[Bug, ...] = (
    # Algorithm 2
    Bug(
        "line 2: starts from empty trackers",
        _algorithm_2("d = [list(tracker.trajectories) for tracker in trackers]", "d = [[] for _ in trackers]"),
        4652,
        {"lemma-1": (5, 1), "lemma-2": (5, 1), "plans-from-truth": (9, 2)},
        worst_rounds=9,
    ),
    Bug(
        "line 5: compares for being different",
        _algorithm_2(_LINE_5, "if trajectory.metadata != uav_message.metadata:"),
        20,
        {"recovery": (2, 0), **_NEVER_RUNS},
    ),
    Bug(
        "line 6: a match keeps the other entries",
        _algorithm_2("d[i] = [trajectory]", ""),
        6527,
        {"recovery": (10, 2)},
    ),
    Bug(
        "line 7: a match clears no flag",
        _algorithm_2("deprecated[i] = False", ""),
        20,
        {"recovery": (2, 0), **_NEVER_RUNS},
    ),
    Bug(
        "line 7: any message of the UAV clears the flag",
        _algorithm_2(
            "deprecated = [tracker.deprecated for tracker in trackers]",
            "deprecated = [tracker.deprecated and i not in uav_messages for i, tracker in enumerate(trackers)]",
        ),
        93715,
        {"lemma-1": (1, 0), "lemma-2": (3, 2), "plans-from-truth": (4, 1)},
        worst_rounds=10,
        slow=True,
    ),
    Bug(
        "lines 12-14: dropped",
        _algorithm_2(_LINE_13, ""),
        34864,
        {"lemma-2": (10, 1)},
        worst_rounds=9,
    ),
    Bug(
        "line 12: two entries are not enough",
        _algorithm_2("several = [len(d_i) > 1 for d_i in d]", "several = [len(d_i) > 2 for d_i in d]"),
        28116,
        {"lemma-2": (10, 1)},
        worst_rounds=9,
        slow=True,
    ),
    Bug(
        "line 13: marks all trackers, as printed",
        _algorithm_2('if semantics.deprecation == "all":', "if True:"),
        13285,
        {"recovery": (12, 3)},
    ),
    Bug(
        "lines 17-19: dropped",
        _algorithm_2(_LINE_18, ""),
        41579,
        _all_of(9, 1),
        worst_rounds=10,
    ),
    Bug(
        "line 17: > instead of the inequality",
        _algorithm_2(_LINE_17, "incomplete = len(cu_messages) > cus"),
        41579,
        _all_of(9, 1),
        worst_rounds=10,
        slow=True,
    ),
    Bug(
        "line 17: tolerates one missing message",
        _algorithm_2(_LINE_17, "incomplete = len(cu_messages) < cus - 1"),
        65548,
        _all_of(9, 1),
        worst_rounds=10,
        slow=True,
    ),
    Bug(
        "line 17: does not count the CU's own message",
        _algorithm_2(_LINE_17, "incomplete = len(cu_messages) != cus - 1"),
        69257,
        {"lemma-1": (9, 3), "lemma-2": (9, 4), "plans-from-truth": (9, 3), "recovery": (2, 0)},
        slow=True,
    ),
    Bug(
        "line 18: marks one tracker only",
        _algorithm_2(_LINE_18, "deprecated = [True, *deprecated[1:]]"),
        34386,
        {"lemma-1": (9, 1), "lemma-2": (9, 1), "plans-from-truth": (10, 1)},
        worst_rounds=9,
        slow=True,
    ),
    Bug(
        "lines 20-24: reads the CU's own message only",
        _algorithm_1(
            "updated = update_information_trackers(inbox.uav_messages, inbox.cu_messages,",
            "updated = update_information_trackers(inbox.uav_messages, "
            "{slot: m if slot == cu.w else EmptyMessage() for slot, m in inbox.cu_messages.items()},",
        ),
        39684,
        {**_all_of(9, 0), "recovery": (11, 2)},
    ),
    Bug(
        "line 22: a new trajectory replaces the others",
        _algorithm_2(_LINE_22, "d[message.uav] = [message.trajectory]"),
        4813,
        {"lemma-1": (9, 1), "lemma-2": (10, 2), "plans-from-truth": (9, 1), "recovery": (9, 3)},
    ),
    Bug(
        "line 22: dropped",
        _algorithm_2(_LINE_22, ""),
        5,
        {"recovery": (0, 0), **_NEVER_RUNS},
    ),
    Bug(
        "lines 20-24 before 3-11: a match throws away what was planned in the same round",
        _algorithm_2(_LINE_22, f"d[message.uav] = d[message.uav] if message.uav in uav_messages else {_LINE_22[17:]}"),
        None,
        {"lemma-1": (9, 2), "lemma-2": (9, 4), "plans-from-truth": (9, 2)},
        max_states=60_000,
        undecided=("recovery",),
        slow=True,
    ),
    # Algorithm 1
    Bug(
        "line 9: runs whatever is deprecated",
        _algorithm_1(_LINE_9, "if may_rejoin:"),
        79,
        {"plans-from-truth": (3, 1), **_NEVER_RUNS},
        worst_rounds=2,
    ),
    Bug(
        "line 9: one tracker up to date is enough",
        _algorithm_1(_LINE_9, "if not all(tracker.deprecated for tracker in trackers) and may_rejoin:"),
        614,
        _NEVER_RUNS,
        worst_rounds=5,
    ),
    Bug(
        "line 9: without the guard of rejoin=after-reply",
        _algorithm_1(
            'may_rejoin = semantics.rejoin == "any-state" or state != CuState.WAIT_FOR_UPDATE', "may_rejoin = True"
        ),
        63568,
        _all_of(8, 0),
        worst_rounds=13,
        slow=True,
    ),
    Bug(
        "line 10: goes on running",
        _algorithm_1(_LINE_10, ""),
        13898,
        {"plans-from-truth": (9, 1)},
        worst_rounds=9,
    ),
    Bug(
        "line 16: a CU that plans nothing stays silent",
        _algorithm_1("return cu, EmptyMessage(prios)  # line 16", "return cu, None"),
        21001,
        {"recovery": (8, 0)},
    ),
    Bug(
        "line 17: plans a UAV with several entries",
        _algorithm_1("if len(cu.trackers[i].trajectories) == 1)", "if len(cu.trackers[i].trajectories) >= 1)"),
        38874,
        {"plans-from-truth": (9, 0)},
        worst_rounds=9,
    ),
    Bug(
        "line 24: dropped, a CU stays in WAIT",
        _algorithm_1(_LINES_23_24, "return cu, EmptyMessage(prios)"),
        10764,
        {"recovery": (10, 2)},
    ),
    Bug(
        "line 26: asks UAV 0 whether deprecated or not",
        _algorithm_1(
            "deprecated = [i for i, tracker in enumerate(cu.trackers) if tracker.deprecated]",
            "deprecated = list(range(len(cu.trackers)))",
        ),
        45,
        {"recovery": (3, 0), **_NEVER_RUNS},
    ),
    Bug(
        "line 28: dropped, a CU keeps its slot and asks again",
        _algorithm_1(_LINE_28, "asked = cu"),
        41800,
        {**_all_of(7, 0), "recovery": (3, 1)},
        slow=True,
    ),
    Bug(
        "line 30: a CU transmits in the slot that it donated",
        _algorithm_1(_LINES_29_31, "return replace(cu, state=CuState.REQUEST_TRAJECTORY), EmptyMessage(prios)"),
        20375,
        {"recovery": (4, 0)},
    ),
    Bug(
        "line 31: dropped, a CU stays silent for ever",
        _algorithm_1(_LINES_29_31, "return cu, None"),
        8,
        {"recovery": (1, 2), **_NEVER_RUNS},
    ),
    # UAV and event trigger
    Bug(
        "a UAV answers no request",
        Edit(uav, "if isinstance(message, TrajectoryRequestMessage) and message.uav == uav.i", "if False"),
        2,
        {"recovery": (0, 0), **_NEVER_RUNS},
    ),
    Bug(
        "A_ET(k): the position does not depend on the CU",
        Edit(event_trigger, _POSITION, "position = k % cus"),
        6294,
        {"one-planner-per-uav": (8, 0)},
        worst_rounds=9,
        overrides=("event_trigger=round-robin",),
        abstraction=Abstraction.ESSENTIAL,
    ),
    Bug(
        "eq. 11: a CU believes its own priorities only",
        _algorithm_1("prio_consensus(inbox.cu_messages.values())", "prio_consensus([inbox.cu_messages[cu.w]])"),
        8333,
        {"one-planner-per-uav": (12, 2)},
        worst_rounds=9,
        overrides=("event_trigger=round-robin",),
        abstraction=Abstraction.ESSENTIAL,
    ),
)

#: Changed lines that break no claim at two UAVs and two CUs: some change nothing, some only what no claim speaks of.
HARMLESS: tuple[Bug, ...] = (
    Bug(
        "line 4: also compares with what was received in this very round (a reply is understood a round earlier)",
        _algorithm_2(
            _LINE_4,
            "for trajectory in (*trackers[i].trajectories, *(m.trajectory for m in cu_messages.values() "
            "if isinstance(m, TrajectoryMessage) and m.uav == i)):",
        ),
        22451,
        worst_rounds=5,
    ),
    Bug(
        "line 8: dropped (metadata are unique: there is no second match)",
        _algorithm_2("break  # line 8", "continue"),
        BASE_STATES,
        worst_rounds=9,
        slow=True,
    ),
    Bug(
        "line 13: spares a UAV that was heard (a message that is heard always matches a tracker that is up to date)",
        _algorithm_2(
            _LINE_13,
            "deprecated = [o or (n and i not in uav_messages) "
            "for i, (o, n) in enumerate(zip(deprecated, marked, strict=True))]",
        ),
        BASE_STATES,
        worst_rounds=9,
    ),
    Bug(
        "line 17: < instead of the inequality (there are never more than M messages)",
        _algorithm_2(_LINE_17, "incomplete = len(cu_messages) < cus"),
        BASE_STATES,
        worst_rounds=9,
        slow=True,
    ),
    Bug(
        "line 4 of Algorithm 1: starts in RUN_DMPC (nothing is known, so line 10 leaves it at once)",
        _algorithm_1(
            "return ComputeUnit(w, CuState.REQUEST_TRAJECTORY, empty)", "return ComputeUnit(w, CuState.RUN_DMPC, empty)"
        ),
        22453,
        worst_rounds=10,
        slow=True,
    ),
    Bug(
        "line 10: asks at once instead of waiting (WAIT avoids useless requests, not wrong ones)",
        _algorithm_1(_LINE_10, "state = CuState.REQUEST_TRAJECTORY"),
        21031,
        worst_rounds=9,
    ),
    Bug(
        "line 10: leaves RUN_DMPC only when all trackers are deprecated (the others can still be planned)",
        _algorithm_1(
            "elif state == CuState.RUN_DMPC:",
            "elif state == CuState.RUN_DMPC and all(tracker.deprecated for tracker in trackers):",
        ),
        27772,
        worst_rounds=9,
        slow=True,
    ),
    Bug(
        "line 23: silent in WAIT (the others deprecate, and recover)",
        _algorithm_1(_LINES_23_24, "return replace(cu, state=CuState.REQUEST_TRAJECTORY), None"),
        22289,
        worst_rounds=9,
        slow=True,
    ),
    Bug(
        "line 24: donates a slot that nobody was offered (costs a round)",
        _algorithm_1(_LINES_23_24, "return replace(cu, state=CuState.WAIT_FOR_UPDATE), EmptyMessage(prios)"),
        22383,
        worst_rounds=10,
        slow=True,
    ),
    Bug(
        "line 31: goes to WAIT",
        _algorithm_1(_LINES_29_31, "return replace(cu, state=CuState.WAIT), None"),
        29695,
        worst_rounds=8,
        slow=True,
    ),
    Bug(
        "eq. 10: a UAV never follows a new trajectory (no claim says that planning has an effect)",
        Edit(uav, _EQ_10, "uav.followed"),
        22053,
        worst_rounds=9,
    ),
    Bug(
        "a UAV that adopts a trajectory forgets whom it owes an answer",
        Edit(
            uav,
            f"return Uav(uav.i, {_EQ_10}, asked_by)",
            f"return Uav(uav.i, {_EQ_10}, asked_by if adopted is None else frozenset())",
        ),
        22403,
        worst_rounds=13,
        slow=True,
    ),
    Bug(
        "line 5: compares the round only (no two CUs plan a UAV in one round)",
        _algorithm_2(_LINE_5, "if trajectory.metadata.round == uav_message.metadata.round:"),
        BASE_STATES_ROUND_ROBIN,
        worst_rounds=9,
        overrides=("event_trigger=round-robin",),
        abstraction=Abstraction.ESSENTIAL,
    ),
    Bug(
        "eq. 11: a zero does not win (a UAV just planned is selected again, and has two entries)",
        Edit(event_trigger, "tuple(0 if 0 in of_uav else max(of_uav)", "tuple(max(of_uav)"),
        8283,
        worst_rounds=9,
        overrides=("event_trigger=round-robin",),
        abstraction=Abstraction.ESSENTIAL,
        slow=True,
    ),
    Bug(
        "A_ET(k): the positions do not rotate",
        Edit(event_trigger, _POSITION, "position = w % cus"),
        8229,
        worst_rounds=9,
        overrides=("event_trigger=round-robin",),
        abstraction=Abstraction.ESSENTIAL,
    ),
    Bug(
        "A_ET(k): ties go to the highest index",
        Edit(event_trigger, "(-priorities[i], i)", "(-priorities[i], -i)"),
        8228,
        worst_rounds=9,
        overrides=("event_trigger=round-robin",),
        abstraction=Abstraction.ESSENTIAL,
        slow=True,
    ),
)


@dataclass(frozen=True)
class NamedBug:
    """A bug that treats trajectories differently because of their names or their order in a tracker.

    Renaming trajectories is no symmetry of it, so it is searched for without any renaming: two UAVs, one CU,
    `guarded` with initial=known.
    """

    name: str
    edit: Edit
    caught: dict[str, tuple[int, int]]


NAMED: tuple[NamedBug, ...] = (
    NamedBug(
        "line 5: true of the first entry",
        _algorithm_2(_LINE_5, "if True:"),
        {"lemma-1": (2, 0), "plans-from-truth": (2, 0)},
    ),
    NamedBug(
        "line 5: compares the CU only",
        _algorithm_2(_LINE_5, "if trajectory.metadata.cu == uav_message.metadata.cu:"),
        {"lemma-1": (4, 0), "plans-from-truth": (4, 0)},
    ),
    NamedBug(
        "line 5: an entry of an earlier round matches, too",
        _algorithm_2(_LINE_5, "if trajectory.metadata.round <= uav_message.metadata.round:"),
        {"lemma-1": (2, 0), "plans-from-truth": (2, 0)},
    ),
)
