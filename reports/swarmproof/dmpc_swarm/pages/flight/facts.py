"""What was flown, for machines and as a table: enough to fly it again, and to tell two flights from each other."""

from __future__ import annotations

from swarmproof.dmpc_swarm.flight.judge import Flown, Judged
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.pages import defaults
from swarmproof.scenario.digest import digest


def as_json(setting: Setting, loss: str) -> dict[str, object]:
    """Return the scenario with its digest, the loss as the user wrote it, trigger, semantics and values not given."""
    return {
        "scenario": {"name": setting.scenario.name, "digest": digest(setting.scenario)},
        "loss": loss,
        "trigger": str(setting.trigger),
        "semantics": setting.semantics.as_dict(),
        "defaults": defaults.as_json(setting.scenario.parameters),
    }


def rows(setting: Setting, loss: str, flown: Flown) -> list[tuple[str, str]]:
    """Return the same, and how far the flight came, as rows of name and text."""
    scenario, last = setting.scenario, flown.last_adoption
    told = [
        ("scenario", f"{scenario.name} (SHA-256 {digest(scenario)})"),
        ("UAVs, CUs", f"{scenario.uavs}, {setting.cus}"),
        ("loss", loss),
        ("trigger", str(setting.trigger)),
        ("semantics", ", ".join(f"{name}={value}" for name, value in setting.semantics.as_dict().items())),
        ("seed", str(setting.seed)),
        ("differs from the published", ", ".join(scenario.differences()) or "nothing"),
        ("not given", defaults.sentence(scenario.parameters, "what is planned, and every verdict,") or "nothing"),
        ("rounds", str(flown.rounds) if flown.stopped is None else flown.stopped),
        (
            "last new trajectory",
            "nobody adopted one"
            if last is None
            else f"adopted in round {last.round} by UAV {last.uav}, planned by CU {last.cu}",
        ),
    ]
    return told


def violations(flown: Flown) -> list[tuple[Judged, str, str]]:
    """Return the violated claims, each with its UAVs and its time as texts; a dash where it has none."""
    found = []
    for judged in flown.claims:
        if judged.place is not None:
            uavs = " and ".join(str(i) for i in judged.place.uavs) or "–"
            found.append((judged, uavs, "–" if judged.place.time is None else f"{judged.place.time:.3f} s"))
    return found
