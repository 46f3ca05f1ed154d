"""The options of `swarmproof claims`, which has none."""

from __future__ import annotations

import argparse

EXAMPLE = "swarmproof claims"
DESCRIPTION = "List the claims: wording, place in the paper, assumptions."
EPILOG = ""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add nothing: the command lists all claims."""
