"""Parameters with which eq. (24) is about nothing: a UAV that cannot move, or no room for two.

Then Δd_min,cont is 0, or no number at all, and (26) says nothing of a swarm that flies: that is no success.
"""

from __future__ import annotations

from fractions import Fraction

from swarmproof.theorem3.inequality import scaled_square
from swarmproof.theorem3.numbers import exact_text
from swarmproof.theorem3.parameters import Parameters, Reading
from swarmproof.theorem3.values import Box


def about_nothing(parameters: Parameters, reading: Reading) -> str:
    """Return why no two UAVs can move relative to each other, or can be d̂_min apart; empty if they can."""
    if _cannot_move(parameters, reading):
        zero = [name for name in ("v_max", "a_max", "j_max") if _is_zero(parameters, name)]
        return f"no UAV can move ({' = '.join(zero)} = 0): give the bounds of UAVs that fly, such as v_max = 1"
    if parameters.workspace is not None and not _has_room(parameters):
        return (
            f"no two UAVs can be d_hat_min = {exact_text(parameters.d_hat_min)} m apart (scaled) within this "
            "workspace: give a larger one, or workspace = none"
        )
    return ""


def _cannot_move(parameters: Parameters, reading: Reading) -> bool:
    """Say whether the states and inputs that are allowed leave every UAV where it is, on all axes.

    whole-motion: the speed is 0 all the time. initial-state: all that moves it later must be 0, too. as-sampled: the
    input is constant over T_s, a multiple of T_b. With speed 0 at the multiples of T_b, a double integrator has
    u·T_b = 0; a triple one with a = 0 there has u·T_b = 0, and one with u = 0 has a·T_b = 0. The speed of any other
    triple one is quadratic over T_s: it is 0 all the time if it is 0 at three samples, but not if at two only.
    """
    if not _is_zero(parameters, "v_max"):
        return False
    if reading is Reading.WHOLE_MOTION:
        return True
    others = [_is_zero(parameters, name) for name in ("a_max", "j_max")[: parameters.order - 1]]
    if reading is Reading.INITIAL_STATE:
        return all(others)
    return parameters.order == 2 or any(others) or parameters.T_b < parameters.T_s


def _is_zero(parameters: Parameters, name: str) -> bool:
    norm: Fraction | None = getattr(parameters, name.replace("max", "norm"))
    return norm == 0 or max(getattr(parameters, name)) == 0


def _has_room(parameters: Parameters) -> bool:
    """Say whether two points of the workspace have a scaled distance of at least d̂_min; without a limit they do."""
    box = parameters.workspace
    assert box is not None
    squares = [scaled_square(parameters.theta_inverse, corner) for corner in _diagonals(box)]
    return not squares or max(squares) >= parameters.d_hat_min**2


def _diagonals(box: Box) -> list[tuple[Fraction, Fraction, Fraction]]:
    """Return the diagonals of the box, of which the longest is the longest way in it; none if a side is open."""
    extents = [high - low for low, high in box if low is not None and high is not None]
    if len(extents) < len(box):
        return []
    x, y, z = extents
    return [(x, s * y, t * z) for s in (1, -1) for t in (1, -1)]
