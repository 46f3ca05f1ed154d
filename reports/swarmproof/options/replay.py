"""The options of `swarmproof replay`."""

from __future__ import annotations

import argparse
from pathlib import Path

EXAMPLE = "swarmproof verify --report report && swarmproof replay report/lemma-1.trace.json"
DESCRIPTION = "Run a trace, step by step, on the readable model. Exit code 1 if it shows a violated claim."
EPILOG = ""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options to the parser of the command."""
    parser.add_argument("trace", type=Path, metavar="TRACE", help="a trace that `verify --report` wrote")
