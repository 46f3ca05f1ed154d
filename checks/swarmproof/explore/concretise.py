"""A way through packed states, told in events: what the search found, on the readable model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from swarmproof.explore.steps import Steps
from swarmproof.port.model import Model


def events_of(model: Model[Any, Any, Any, Any], state: Any, lossless: bool = False) -> Iterator[tuple[Any, Any]]:
    """Yield everything that can happen in the next round: (event, state after it); some states more than once."""
    for choice in model.choices(state):
        sent = model.compute(state, choice)
        for event in model.events(sent, lossless):
            yield event, model.receive(sent, event)


def follow(
    model: Model[Any, Any, Any, Any], steps: Steps, path: Sequence[int], lossless_from: int | None = None
) -> list[Any]:
    """Return events that take the readable model from its initial state along the keys of `path` (its key first).

    From position `lossless_from` of the path on, nothing may be lost. What the search called a round must be one of
    the readable model: AssertionError otherwise.
    """
    state, told = model.initial(), []
    assert steps.pack(state) == path[0]
    for position, key in enumerate(path[1:]):
        lossless = lossless_from is not None and position >= lossless_from
        fitting = [
            (event.lost, number, event, after)
            for number, (event, after) in enumerate(events_of(model, state, lossless))
            if steps.pack(after) == key
        ]
        assert fitting, "the search took a round that the readable model cannot take"
        _, _, event, state = min(fitting, key=lambda one: one[:2])
        told.append(event)
    return told
