"""What several commands' options have in common: their values, and limits of a search."""

from __future__ import annotations

import argparse


def whole_number(text: str) -> int:
    """Return the whole number, at least 0, in `text`: an argparse type."""
    if not text.isdecimal() or len(text) > 9:
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number of at least 0, such as 3")
    return int(text)


def positive_number(text: str) -> int:
    """Return the whole number, at least 1, in `text`: an argparse type."""
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number of at least 1, such as 3")
    return number


def positive_seconds(text: str) -> float:
    """Return the number of seconds in `text`: an argparse type."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 0 < seconds < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is no positive number of seconds, such as 60")
    return seconds


def add_limits(parser: argparse.ArgumentParser, states: str = "states") -> None:
    """Add the options that end a search early; `states` says what is counted."""
    parser.add_argument("--max-states", type=positive_number, metavar="K", help=f"stop after K {states}: undecided")
    parser.add_argument("--max-seconds", type=positive_seconds, metavar="S", help="stop after S seconds: undecided")
