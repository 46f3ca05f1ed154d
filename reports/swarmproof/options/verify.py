"""The options of `swarmproof verify`."""

from __future__ import annotations

import argparse

from swarmproof.options.values import add_limits, positive_number
from swarmproof.systems import PACKAGES, USUAL, reading_of

EXAMPLE = "swarmproof verify --uavs 2 --cus 2 --semantics guarded"
DESCRIPTION = "Explore every message-loss pattern, over an unbounded number of rounds, and decide each claim."
EPILOG = (
    "Exit codes: 0 no claim violated, 1 some claim violated (--matrix: some verdict is not the one on record), 2 bad "
    "input, 3 something undecided, or stopped."
)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options to the parser of the command."""
    parser.add_argument(
        "--system",
        default=USUAL,
        metavar="NAME",
        help=f"what is verified: {', '.join(PACKAGES)} (default {USUAL}); another has presets and switches of its own",
    )
    parser.add_argument("--uavs", type=positive_number, metavar="N", help="number of UAVs (default 2)")
    parser.add_argument("--cus", type=positive_number, metavar="M", help="number of compute units (default 2)")
    parser.add_argument(
        "--semantics",
        metavar="PRESET",
        help=f"how the paper is read: {', '.join(reading_of(USUAL).PRESETS)} (default printed)",
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="SWITCH=VALUE", help="change one switch of the preset"
    )
    parser.add_argument("--claim", action="append", default=[], metavar="ID", help="decide only this claim")
    parser.add_argument("--json", metavar="FILE", help="write the verdicts as JSON; - for standard output")
    parser.add_argument("--report", metavar="DIR", help="write pages and replayable traces into this folder")
    add_limits(parser)
    parser.add_argument(
        "--matrix",
        action="store_true",
        help="verify the recorded configurations and compare; --uavs, --cus, --semantics select among them",
    )
