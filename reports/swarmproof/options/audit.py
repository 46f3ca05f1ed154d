"""The options of `swarmproof audit`."""

from __future__ import annotations

import argparse

EXAMPLE = "swarmproof audit --claim lemma-3"
DESCRIPTION = "The proofs of Section 4.3.2 and Appendix C: what each statement needs, covers, and leaves out."
EPILOG = "Exit codes: 0 every verdict is the one on record, 1 one is not, 2 bad input, 3 one is not decided."


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options to the parser of the command."""
    parser.add_argument(
        "--claim", action="append", default=[], metavar="ID", help="only this claim, with its evidence; repeatable"
    )
    parser.add_argument("--report", metavar="DIR", help="write a page with every claim, its evidence and pictures")
    parser.add_argument("--json", metavar="FILE", help="write the verdicts as JSON; - for standard output")
