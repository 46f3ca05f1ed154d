"""The options of `swarmproof claims`."""

from __future__ import annotations

import argparse

from swarmproof.systems import PACKAGES

EXAMPLE = "swarmproof claims"
DESCRIPTION = "List the claims: wording, place in the paper, assumptions."
EPILOG = ""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the option to the parser of the command."""
    parser.add_argument(
        "--system", metavar="NAME", help=f"list only what is claimed about one system: {', '.join(PACKAGES)}"
    )
