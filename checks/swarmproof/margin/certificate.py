"""Writes what was found as a certificate (docs/margin.md, "The certificate")."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from swarmproof.margin.ball import BallLeaf
from swarmproof.margin.functional import Density, Multiplier
from swarmproof.margin.polygon import Edge
from swarmproof.margin.problem import Problem
from swarmproof.margin.prove import Cell, Leaf, Tree
from swarmproof.margin.witness import Motion, Witness, make_witness
from swarmproof.motion.integrator import AxisMotion
from swarmproof.theorem3.numbers import exact_text
from swarmproof.theorem3.parameters import EXTENSIONS, Reading

SCHEMA = "swarmproof.margin-certificate/1"
#: With bounds of the norm, an open side of the workspace, or another parameter that the paper does not have.
EXTENDED = "swarmproof.margin-certificate/2"


def certificate(
    problem: Problem,
    lower: Fraction,
    upper: Fraction,
    witness: Witness | None,
    windows: Mapping[int, Sequence[Cell]] | None,
) -> dict[str, Any]:
    """Return the certificate as JSON objects; `windows` are the proofs of *upper*, None where it is d̂_min."""
    parameters = problem.parameters.as_exact()
    schema = EXTENDED if _is_extended(parameters) else SCHEMA
    content: dict[str, Any] = {
        "schema": schema,
        "parameters": parameters,
        "reading": problem.reading.value,
        "dip": {"lower": exact_text(lower), "upper": exact_text(upper)},
        "witness": None if witness is None else _witness(witness),
        "windows": None
        if windows is None
        else [
            {
                "window": window,
                "cells": [_cell(problem, cell, schema) for cell in sorted(cells, key=lambda cell: cell.early)],
            }
            for window, cells in sorted(windows.items())
        ],
    }
    return {**content, "digest": digest(content)}


def _is_extended(parameters: Mapping[str, Any]) -> bool:
    space = parameters["workspace"]
    return any(name in parameters for name in EXTENSIONS) or (
        space is not None and any(side is None for sides in space for side in sides)
    )


def digest(content: Mapping[str, Any]) -> str:
    """Return the SHA-256 (hex) of a certificate without its digest."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def _witness(witness: Witness) -> dict[str, Any]:
    def motion(axes: Motion) -> list[dict[str, Any]]:
        return [
            {
                "state": [exact_text(value) for value in axis.state],
                "inputs": [[exact_text(duration), exact_text(value)] for duration, value in axis.inputs],
            }
            for axis in axes
        ]

    return {
        "window": witness.window,
        "tau": exact_text(witness.tau),
        "uav_i": motion(witness.uav_i),
        "uav_j": motion(witness.uav_j),
    }


def read_witness(problem: Problem, content: Mapping[str, Any]) -> Witness:
    """Return the witness of a certificate that the checker has accepted."""

    def motion(axes: Sequence[Mapping[str, Any]]) -> Motion:
        return tuple(
            AxisMotion(
                tuple(Fraction(value) for value in axis["state"]),
                tuple((Fraction(duration), Fraction(value)) for duration, value in axis["inputs"]),
            )
            for axis in axes
        )

    return make_witness(
        problem, content["window"], Fraction(content["tau"]), motion(content["uav_i"]), motion(content["uav_j"])
    )


def _cell(problem: Problem, cell: Cell, schema: str) -> dict[str, Any]:
    length = problem.parameters.T_c
    ball = {"ball": [_edge(problem, edge) for edge in cell.ball]} if schema == EXTENDED else {}
    return {
        "from": exact_text(cell.early * length),
        "to": exact_text(cell.late * length),
        "edges": [[_edge(problem, edge) for edge in edges] for edges in cell.edges],
        "axes": list(cell.kinds),
        **ball,
        "tree": _tree(cell.tree),
    }


def _edge(problem: Problem, edge: Edge) -> dict[str, Any]:
    return {
        "direction": [_text(value) for value in edge.direction],
        "proofs": [[_multiplier(problem, used) for used in proof] for proof in edge.proofs],
    }


def _multiplier(problem: Problem, used: Multiplier) -> list[Any]:
    if isinstance(used, Density):
        times = (_time(problem, used.start), _time(problem, used.end))
        return [*times, used.derivative, _text(used.first), _text(used.last)]
    return [_time(problem, used.time), used.derivative, _text(used.weight)]


def _time(problem: Problem, time: float) -> str:
    """Return a time as text: exactly a multiple of T_b where one is meant, and never beyond T_c."""
    given = problem.parameters
    if problem.reading is Reading.AS_SAMPLED:
        return exact_text(round(time / float(given.T_b)) * given.T_b)
    return exact_text(given.T_c) if time >= float(given.T_c) - 1e-12 else _text(time)


def _text(value: float) -> str:
    """Return the shortest decimal that is this float, as an exact number."""
    return exact_text(Fraction(repr(float(value))))


def _tree(tree: Tree | None) -> dict[str, Any] | None:
    if tree is None:
        return None
    if isinstance(tree, Leaf):
        return {"t": _text(tree.t)}
    if isinstance(tree, BallLeaf):
        return {"t": _text(tree.t), "share": _text(tree.share), "weights": [_text(value) for value in tree.weights]}
    return {
        "axis": tree.axis,
        "normal": [_text(value) for value in tree.normal],
        "at": _text(tree.at),
        "below": _tree(tree.below),
        "above": _tree(tree.above),
    }
