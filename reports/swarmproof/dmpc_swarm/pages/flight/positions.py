"""The positions and plans of a flight as a file: `swarmproof.positions/1` as JSON, or the positions alone as CSV."""

from __future__ import annotations

import csv
import json
from io import StringIO
from pathlib import Path
from typing import Any

from swarmproof.dmpc_swarm.flight.positions import PlanRow, Positions
from swarmproof.dmpc_swarm.flight.run import Setting
from swarmproof.dmpc_swarm.pages.flight.bounds import bounds_document
from swarmproof.errors import BadInput
from swarmproof.files.writing import write
from swarmproof.scenario.digest import digest

SCHEMA = "swarmproof.positions/1"
COLUMNS = ("time", "round", "uav", "x", "y", "z", "actual_x", "actual_y", "actual_z")
FORMATS = (".csv", ".json")
UNITS = "s, m, m/s, m/s², m/s³; floats nearest to the exact numbers"


def check_format(path: Path) -> None:
    """Raise :class:`BadInput` if the name of the file says no format that is written."""
    if path.suffix.lower() not in FORMATS:
        raise BadInput(f"--positions {path} is neither CSV nor JSON: give a file such as flight.csv or flight.json")


def write_positions(path: Path, setting: Setting, positions: Positions) -> None:
    """Write the file; its name ends as :func:`check_format` wants it.

    Raises:
        Failed: it cannot be written.
    """
    write(path, as_csv(positions) if path.suffix.lower() == ".csv" else as_json(setting, positions))


def as_csv(positions: Positions) -> str:
    """Return the positions, a line for each UAV and multiple of T_c below a line of :data:`COLUMNS`; s and m."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(_rows(positions))
    return text.getvalue()


def as_json(setting: Setting, positions: Positions) -> str:
    """Return the positions in rows of :data:`COLUMNS`, and all plans: each of the two is enough to check distances."""
    scenario = setting.scenario
    parameters = scenario.parameters.as_json()
    content = {
        "schema": SCHEMA,
        "scenario": {"name": scenario.name, "digest": digest(scenario)},
        "units": UNITS,
        "T_c": parameters["T_c"],
        "T_s": parameters["T_s"],
        "horizon": scenario.horizon,
        "theta_inverse": parameters["theta_inverse"],
        # what a distance is scaled with otherwise: only where somebody gave it
        **{name: parameters[name] for name in ("crash_theta_inverse",) if name in parameters},
        **bounds_document(scenario),
        "columns": list(COLUMNS),
        "plans": [_plan(plan, float(scenario.parameters.T_s)) for plan in positions.plans()],
        "rows": list(_rows(positions)),
    }
    # a row a line: such files are long
    parts = [f" {json.dumps(key)}: {_lines(value)}" for key, value in content.items()]
    return "{\n" + ",\n".join(parts) + "\n}\n"


def _lines(value: Any) -> str:
    if isinstance(value, list) and value and isinstance(value[0], (list, dict)):
        return "[\n  " + ",\n  ".join(json.dumps(one) for one in value) + "\n ]"
    return json.dumps(value, ensure_ascii=False)


def _rows(positions: Positions) -> list[list[float | int]]:
    return [[float(row.time), row.round, row.uav, *row.reference, *row.actual] for row in positions.rows()]


def _plan(plan: PlanRow, period: float) -> dict[str, Any]:
    position, velocity, acceleration = plan.state
    return {
        "uav": plan.uav,
        "round": plan.round,
        "cu": plan.cu,
        "start": float(plan.start),
        "position": position,
        "velocity": velocity,
        "acceleration": acceleration,
        "jerks": plan.jerks,
        "adopted": plan.adopted,
        # rounds count from 0: what is adopted in round k is followed from time (k + 1)·T on
        "followed_from": None if plan.adopted is None else (plan.adopted + 1) * period,
    }
