"""What ends a command without a verdict: what was given is at fault, or the world around it."""

from __future__ import annotations


class BadInput(ValueError):
    """An error of whoever gave the input, in one sentence: what, where, and what would be right."""


class Failed(Exception):
    """A failure of the world around us (a full disk, a closed pipe, a killed worker), in one sentence.

    It says nothing about what was given, and nothing about a paper.
    """
