"""Records the matrix anew: `python -m swarmproof.dmpc_swarm.record > matrix.toml`. A person reads the difference."""

from __future__ import annotations

import sys
from collections.abc import Iterator

from swarmproof.campaign.matrix import Row, as_toml, run_matrix
from swarmproof.dmpc_swarm.semantics import PRESETS, SWITCHES, Semantics
from swarmproof.dmpc_swarm.system import SYSTEM
from swarmproof.explore.search import Limits


def configurations() -> Iterator[Row]:
    """Yield what the matrix is about: every preset with every value of every switch at 2 x 2, and some other sizes."""
    seen: set[tuple[int, int, Semantics]] = set()

    def row(uavs: int, cus: int, preset: str, *overrides: str) -> Iterator[Row]:
        semantics = Semantics.parse(preset, overrides)
        if (uavs, cus, semantics) not in seen:
            seen.add((uavs, cus, semantics))
            yield Row(SYSTEM, {"uavs": uavs, "cus": cus}, preset, overrides, {})

    for uavs, cus in ((2, 1), (2, 2), (3, 2)):
        for preset in PRESETS:
            yield from row(uavs, cus, preset)
    for preset in PRESETS:
        for switch, values in SWITCHES.items():
            # the older DMPC is a preset of its own, and starts only from what is known
            if switch == "loss_handling" or (switch == "initial" and preset == "ignore-loss"):
                continue
            for value in values:
                yield from row(2, 2, preset, f"{switch}={value}")
    yield from row(3, 2, "prose", "slot_conflict=cu-wins")
    yield from row(3, 2, "guarded", "event_trigger=round-robin")
    yield from row(3, 2, "ignore-loss", "event_trigger=round-robin")
    yield from row(2, 3, "guarded")
    for uavs in (3, 4, 5, 6):
        yield from row(uavs, 1, "guarded")


def main() -> None:
    """Verify every configuration and print the matrix."""
    rows = list(configurations())

    def tell(row_result: object) -> None:
        print(".", end="", file=sys.stderr, flush=True)

    def say(sentence: str) -> None:
        print(sentence, file=sys.stderr)

    for line in as_toml(run_matrix(rows, Limits(), 2, tell, say)):
        print(line)


if __name__ == "__main__":
    main()
