"""The options of `swarmproof fly`."""

from __future__ import annotations

import argparse

from swarmproof.dmpc_swarm.semantics import PRESETS
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.faults.forms import COMBINED, FORMS
from swarmproof.options.values import add_limits, whole_number
from swarmproof.scenario.scenario import SHIPPED

#: Forms of --loss that are no loss models but searches for losses.
SEARCHES = ("adversary:BUDGET", "exhaustive:ROUNDS")


def _loss_help() -> str:
    """Return how losses are written, with examples."""
    width = max(len(example) for example, _ in COMBINED.values()) + 4
    lines = [f"  {example!r:{width}}{meaning}" for example, meaning in COMBINED.values()]
    return "\n".join(["--loss takes a search, a model, or what is made of models (in quotes, for the shell):", *lines])


EXAMPLE = "swarmproof fly crossing --loss iid:0.1 --rounds 30"
DESCRIPTION = "Fly a scenario: the protocol with real trajectories, planned by (13) and checked exactly."
EPILOG = (
    _loss_help() + "\n\nExit codes: 0 nothing violated, 1 something violated, 2 bad input, 3 something undecided, or "
    "stopped."
)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options to the parser of the command."""
    parser.add_argument("scenario", metavar="SCENARIO", help=f"a TOML file, or one of {', '.join(SHIPPED)}")
    parser.add_argument("--cus", type=whole_number, default=2, metavar="M", help="number of compute units (default 2)")
    parser.add_argument("--trigger", default="HT", metavar="T", help=f"{', '.join(Trigger)} (default HT)")
    parser.add_argument(
        "--loss", default="none", metavar="SPEC", help=f"{', '.join([*FORMS, *SEARCHES])}; see below (default none)"
    )
    parser.add_argument(
        "--semantics", default="guarded", metavar="PRESET", help=f"as in verify: {', '.join(PRESETS)} (default guarded)"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="change a switch, or a parameter of the scenario",
    )
    parser.add_argument("--seed", type=whole_number, default=0, metavar="S", help="of everything random (default 0)")
    parser.add_argument(
        "--rounds", type=whole_number, metavar="K", help="length of the flight (default: the scenario's)"
    )
    add_limits(parser, states="swarms (--loss exhaustive)")
    parser.add_argument("--json", metavar="FILE", help="write the result as JSON; - for standard output")
    parser.add_argument(
        "--positions", metavar="FILE", help="write all positions at multiples of T_c (.csv), with all plans (.json)"
    )
    parser.add_argument("--report", metavar="DIR", help="write a page with pictures into this folder")
