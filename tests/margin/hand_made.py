"""Margin certificates that were written, and whose truth is known, by hand; and ways to alter them."""

from __future__ import annotations

import copy
import hashlib
import json
from typing import Any

Json = dict[str, Any]

# Two UAVs fly past each other along x, 0.8 m apart in y, each at v_max = 0.6 m/s. At both ends of a window of 1 s they
# are 0.6 m apart in x, so 1 m in all, and in its middle 0.8 m: a dip of 0.2 m.
#
# The upper bounds are worked out by hand. With T_c = 1, t = 0 and one cell, κ = 1/4 and g ≤ e = w̄''/8, so (*) is
# √(1 − δ²/4) − e. The bounds of the inputs are such that δ is 1.2 or 1.6, and the root 0.8 or 0.6. By reading and
# order: a_max and j_max along x, the multipliers that bound δ, and the dip that is proved.
CASES: dict[tuple[str, int], tuple[str, str, list[list[Any]], str]] = {
    # δ ≤ 2v + 2a/2 = 1.6; e = 2a/8 = 0.1
    ("initial-state", 2): ("0.4", "0", [], "0.5"),
    # δ ≤ 2v + 2a/2 + 2j/6 = 1.6; e = 2(a + j)/8 = 0.2
    ("initial-state", 3): ("0.2", "0.6", [], "0.6"),
    # δ − w'(1/2) has the kernel −s, later 1 − s, so δ ≤ 2v + 2a/4 = 1.6; e = 2a/8 = 0.2
    ("whole-motion", 2): ("0.8", "0", [["1/2", 1, "1"]], "0.6"),
    # δ − w'(1/2) has the kernel s²/2, later (1 − s)²/2, so δ ≤ 2v + 2j/24 = 1.6; e = 2a/8 = 0.1
    ("whole-motion", 3): ("0.4", "4.8", [["1/2", 1, "1"]], "0.5"),
    # if u is constant, δ = w'(1/2), so δ ≤ 2v = 1.2; e = 2a/8 = 0.1
    ("as-sampled", 2): ("0.4", "0", [["1/2", 1, "1"]], "0.3"),
    # δ − w'(1/2) = u/24, so δ ≤ 2v + 2j/24 = 1.6; e = 2a/8 = 0.1
    ("as-sampled", 3): ("0.4", "4.8", [["1/2", 1, "1"]], "0.5"),
}
LOWER = "0.2"


def signed(certificate: Json) -> Json:
    """Return a certificate with the right digest, whatever it had before."""
    rest = {key: value for key, value in certificate.items() if key != "digest"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return {**rest, "digest": hashlib.sha256(text.encode("ascii")).hexdigest()}


def uav(x: str, velocity: str, y: str, order: int, duration: str) -> list[Json]:
    """Return a UAV that flies at constant velocity along x, at this y."""
    rest = ["0"] * (order - 1)
    states = [[x, velocity, *rest[1:]], [y, *rest], ["0", *rest]]
    return [{"state": state, "inputs": [[duration, "0"]]} for state in states]


def edges_of(multipliers: list[list[Any]]) -> list[Json]:
    """Return edges for δ, which these multipliers bound at both ends of a cell, and for g, without any."""
    return [
        {"direction": ["1", "0"], "proofs": [multipliers, multipliers]},
        {"direction": ["0", "1"], "proofs": [[], []]},
    ]


def cell_of(multipliers: list[list[Any]], first: str = "0", last: str = "1") -> Json:
    """Return a cell with such edges for all axes, and one leaf."""
    tree = {"t": "0"}
    return {"from": first, "to": last, "edges": [edges_of(multipliers)], "axes": [0, 0, 0], "tree": tree}


def made(reading: str, order: int) -> Json:
    """Return a hand-made certificate. The UAVs do not move along y and z, so that the arithmetic stays easy."""
    a_max, j_max, multipliers, upper = CASES[reading, order]
    duration = "2" if reading == "as-sampled" else "1"
    parameters = {
        "T_c": "1",
        "T_s": "2",
        "T_b": "1/2",
        "d_hat_min": "1",
        "v_max": ["0.6", "0", "0"],
        "a_max": [a_max, "0", "0"],
        "j_max": [j_max, "0", "0"],
        "theta_inverse": [["1", "0", "0"], ["0", "1", "0"], ["0", "0", "1"]],
        "order": order,
        "workspace": None,
        "d_min": "0.9",
        "tracking_error": "0.05",
    }
    certificate = {
        "schema": "swarmproof.margin-certificate/1",
        "parameters": parameters,
        "reading": reading,
        "dip": {"lower": LOWER, "upper": upper},
        "witness": {
            "window": 0,
            "tau": "0.5",
            "uav_i": uav("-0.3", "0.6", "0.4", order, duration),
            "uav_j": uav("0.3", "-0.6", "-0.4", order, duration),
        },
        "windows": [{"window": 0, "cells": [cell_of(multipliers)]}],
    }
    return signed(certificate)


def altered(certificate: Json, changes: dict[str, Any]) -> Json:
    """Return a certificate with other values at some paths, such as `windows/0/cells`, and the right digest."""
    changed = copy.deepcopy(certificate)
    for path, value in changes.items():
        *before, last = (int(key) if key.isdigit() else key for key in path.split("/"))
        place: Any = changed
        for key in before:
            place = place[key]
        place[last] = value
    return signed(changed)


CELL = "windows/0/cells/0"


def places(value: object, path: tuple[str, ...] = ()) -> list[str]:
    """Return the paths of all leaves of a JSON value."""
    if isinstance(value, dict):
        return [place for key, one in value.items() for place in places(one, (*path, key))]
    if isinstance(value, list) and value:
        return [place for i, one in enumerate(value) for place in places(one, (*path, str(i)))]
    return ["/".join(path)]
