"""The options of `swarmproof margin`."""

from __future__ import annotations

import argparse

from swarmproof.options.values import whole_number
from swarmproof.theorem3.parameters import EXTREMES, Reading

EXAMPLE = "swarmproof margin --set T_c=0.05 --d-min 0.12 --tracking-error 0.02"
DESCRIPTION = (
    "How far two reference trajectories can dip below d̂_min between two samples, certified. Bounds are per axis "
    "(v_max, a_max, j_max), of the Euclidean norm (v_norm, a_norm, j_norm), or both. delay: how long a UAV flies on "
    "unknown; crash_theta_inverse: what d_min is measured with; [[kinds]]: every pair of them."
)
EPILOG = (
    "Exit codes: 0 the corrected inequality (26) holds, 1 it fails, 3 undecided or about nothing, 2 bad input; "
    "--check: 0 accepted, 1 rejected; --solve-for: 0 a value is certified, 1 all are refuted, 3 neither."
)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options to the parser of the command."""
    parser.add_argument("parameters", nargs="?", metavar="PARAMETERS.toml", help="default: the published parameters")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="change one parameter")
    parser.add_argument("--d-min", metavar="M", help="distance that counts as a collision, scaled (default 0.12)")
    parser.add_argument("--tracking-error", metavar="M", help="Δd_min of Assumption 1, per UAV, unscaled (default 0)")
    parser.add_argument(
        "--reading", default="as-sampled", metavar="R", help=f"{', '.join(Reading)} (default as-sampled)"
    )
    parser.add_argument("--json", metavar="FILE", help="write the result as JSON; - for standard output")
    parser.add_argument("--certificate", metavar="FILE", help="write the certificate, which --check verifies")
    parser.add_argument("--plot", metavar="FILE", help="draw the worst pair, or the sweep (.svg, .png, .pdf)")
    parser.add_argument(
        "--solve-for",
        choices=EXTREMES,
        metavar="NAME",
        help=f"extreme value that is still safe: {', '.join(EXTREMES)} (v_max: one number for all axes; v_norm: the "
        "norm)",
    )
    parser.add_argument("--check", metavar="CERTIFICATE", help="verify a certificate exactly, and nothing else")
    parser.add_argument(
        "--sweep", action="append", default=[], metavar="NAME=V1:V2:…", help="vary a parameter (or reading); repeatable"
    )
    parser.add_argument(
        "--changes", type=whole_number, metavar="K", help="of a sweep, only sets with at most K changes"
    )
    parser.add_argument(
        "--results", metavar="DIR", help="certificates of a sweep or of [[kinds]]; a later run goes on from there"
    )
