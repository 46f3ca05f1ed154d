"""What a flight has beyond one box and one distance for all: norms, kinds of UAVs, an ellipsoid of crashes.

In words, and for the JSON document; nothing is said where there is nothing of the kind.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import floor

from swarmproof.dmpc_swarm.planner.ball import share
from swarmproof.motion.lattice import binding_norms
from swarmproof.scenario.scenario import Scenario
from swarmproof.theorem3.numbers import exact_text
from swarmproof.theorem3.values import NORMS, OF_A_KIND, Vector

_UNITS = {"v_norm": "m/s", "a_norm": "m/s²", "j_norm": "m/s³"}


def bounds_in_words(scenario: Scenario) -> str:
    """Return all of it, as sentences after another one."""
    return _kinds(scenario) + _crash(scenario) + _norms(scenario) + _per_axis(scenario)


def _norms(scenario: Scenario) -> str:
    norms = sorted({item for given in scenario.fleet.parameters for item in binding_norms(given).items()})
    if not norms:
        return ""
    texts = [f"{name}={exact_text(norm)} {_UNITS[name]}" for name, norm in norms]
    return (
        f" Bounds of norms ({', '.join(texts)}) are accepted exactly; plans are looked for within a polyhedron that "
        f"reaches at least {floor(1000 * share()) / 10:g} % of them in every direction."
    )


def _kinds(scenario: Scenario) -> str:
    if not scenario.kinds:
        return ""
    given = scenario.parameters
    texts = [
        f"{kind.name} (UAV{'' if len(kind.uavs) == 1 else 's'} {_listed(kind.uavs)}: "
        f"{kind.parameters.describe(given) or 'as the others'})"
        for kind in scenario.kinds
    ]
    return (
        f" Kinds: {'; '.join(texts)}. Two UAVs keep the mean of their d_hat_min and d_min. Distances are scaled pair "
        f"by pair: at samples such that all keep d_hat_min={exact_text(given.d_hat_min)} m, at any time such that all "
        f"collide below d_min={exact_text(given.d_min)} m."
    )


def _crash(scenario: Scenario) -> str:
    if all(given.crash_theta_inverse is None for given in scenario.fleet.parameters):
        return ""
    return " Distances at samples are scaled by theta_inverse, those at any time by crash_theta_inverse."


def _per_axis(scenario: Scenario) -> str:
    """Return that three numbers are three axes, where there are three UAVs, which they might be taken for."""
    given = scenario.parameters
    names = [name for name in NORMS.values() if len(set(getattr(given, name))) > 1]
    if scenario.uavs != 3 or not names:
        return ""
    texts = [f"{name}={_vector(getattr(given, name))}" for name in names]
    return (
        f" Three numbers are the axes x, y, z of every UAV ({', '.join(texts)} per axis), not three UAVs: UAVs that "
        "differ are of [[kinds]], with a line such as uavs = [0]."
    )


def bounds_document(scenario: Scenario) -> dict[str, object]:
    """Return the same for the JSON document: `norms` of the parameters, and `kinds`."""
    norms = {name: float(norm) for name, norm in binding_norms(scenario.parameters).items()}
    kinds = [
        {
            "name": kind.name,
            "uavs": list(kind.uavs),
            "parameters": {name: value for name, value in kind.parameters.as_json().items() if name in OF_A_KIND},
        }
        for kind in scenario.kinds
    ]
    bounded = any(binding_norms(given) for given in scenario.fleet.parameters)
    return {
        **({"norms": {**norms, "planned_share": floor(1000 * share()) / 1000}} if bounded else {}),
        **({"kinds": kinds} if kinds else {}),
    }


def _listed(uavs: Iterable[int]) -> str:
    return ", ".join(str(uav) for uav in uavs)


def _vector(vector: Vector) -> str:
    return ",".join(exact_text(part) for part in vector)
