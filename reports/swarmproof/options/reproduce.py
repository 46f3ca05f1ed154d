"""The options of `swarmproof reproduce`."""

from __future__ import annotations

import argparse
import os

from swarmproof.dmpc_swarm.claims.experiment_names import EXPERIMENT_NAMES
from swarmproof.options.values import whole_number

EXAMPLE = "swarmproof reproduce fig3b --quick --report out/fig3b"
DESCRIPTION = (
    "The experiments of Section 5 on our swarm, over many seeds: what agrees with the paper, what does not, and which "
    "of our choices matter. Stopped, it goes on where it was."
)
EPILOG = "Exit codes: 0 all statements agree, 1 one does not, 2 bad input, 3 one is not decided, or interrupted."


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options to the parser of the command."""
    parser.add_argument("experiment", metavar="EXPERIMENT", help=", ".join(EXPERIMENT_NAMES))
    parser.add_argument("--quick", action="store_true", help="a small version, in less than two minutes")
    parser.add_argument(
        "--as-chosen", action="store_true", help="only with our choices, not with each of them changed as well"
    )
    parser.add_argument(
        "--results",
        default="out/results",
        metavar="DIR",
        help="where results are kept: what is there is not flown again (default out/results)",
    )
    parser.add_argument(
        "--processes", type=whole_number, default=os.cpu_count() or 1, metavar="P", help="default: one for each core"
    )
    parser.add_argument(
        "--cell", action="append", default=[], metavar="ID", help="fly this cell again and compare; repeatable"
    )
    parser.add_argument("--report", metavar="DIR", help="write a page with plots, tables and all cells")
    parser.add_argument("--json", metavar="FILE", help="write the verdicts as JSON; - for standard output")
