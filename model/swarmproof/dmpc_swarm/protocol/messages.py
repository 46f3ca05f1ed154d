"""What is on the air: trajectories, their metadata, and the messages of UAVs and CUs (Sections 3.3, 4.2.1)."""

from __future__ import annotations

from typing import NamedTuple

#: Priorities of all UAVs, J_i for i = 0 ... N-1 (Appendix A); None where the message carries none.
Priorities = tuple[int, ...] | None


class Metadata(NamedTuple):
    """What identifies a trajectory of a UAV: the round of its calculation and the CU that calculated it."""

    round: int
    cu: int


class Trajectory(NamedTuple):
    """A trajectory, opaque but for its metadata (Section 4.2.1: "the calculation time and the responsible CU")."""

    metadata: Metadata


#: What every UAV follows at first (Remark 2); it counts as calculated in round -1, by nobody.
HOVERING = Trajectory(Metadata(-1, -1))


class UavMessage(NamedTuple):
    """Every UAV, every round: the metadata of the trajectory that it follows in that round."""

    metadata: Metadata


class EmptyMessage(NamedTuple):
    """A CU has nothing to say but its priorities (Alg. 1, lines 16 and 23)."""

    priorities: Priorities = None


class TrajectoryMessage(NamedTuple):
    """A trajectory for UAV `uav`: newly planned (Alg. 1, line 19), or a UAV's reply to a request (no priorities)."""

    uav: int
    trajectory: Trajectory
    priorities: Priorities = None


class TrajectoryRequestMessage(NamedTuple):
    """A CU asks UAV `uav` for its current trajectory, and donates its next slot to it (Alg. 1, line 27)."""

    uav: int
    priorities: Priorities = None


CuMessage = EmptyMessage | TrajectoryMessage | TrajectoryRequestMessage
