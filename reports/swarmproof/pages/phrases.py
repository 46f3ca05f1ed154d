"""Phrases: numbers with their nouns, and lists, as sentences and pages have them."""

from __future__ import annotations

from collections.abc import Sequence


def listing(parts: Sequence[str]) -> str:
    """Return ``a, b and c``."""
    *most, last = parts or [""]
    return f"{', '.join(most)} and {last}" if most else last


def count(number: int, noun: str) -> str:
    """Return ``1 round`` or ``2 rounds``."""
    return f"{number:,} {noun}" if number == 1 else f"{number:,} {noun}s"


def rounds(first: int, last: int) -> str:
    """Return ``round 3``, ``rounds 3 and 4`` or ``rounds 3 to 5``."""
    if first == last:
        return f"round {first}"
    return f"rounds {first} {'and' if last == first + 1 else 'to'} {last}"


def losses(number: int) -> str:
    """Return how many messages a run loses, in words."""
    return "no message lost" if number == 0 else f"{count(number, 'message')} lost"
