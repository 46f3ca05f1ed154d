"""The systems under test: the one list of them. It is light: help and options read it.

A system is a package `swarmproof.NAME` with a module `system` in `checks`, whose `SYSTEM` is loaded by name; no engine
imports it. ARCHITECTURE.md says what to write for a new one.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, cast

from swarmproof.errors import BadInput

if TYPE_CHECKING:
    from swarmproof.claims.reading import Reading
    from swarmproof.system import System

#: By the name in traces and documents, the package of a system.
PACKAGES: dict[str, str] = {"mlr-dmpc": "dmpc_swarm", "heartbeat": "heartbeat"}
#: The system that is meant where none is named.
USUAL = "mlr-dmpc"


def load(name: str) -> System:
    """Return the system of this name.

    Raises:
        BadInput: there is none.
    """
    if name not in PACKAGES:
        raise BadInput(f"there is no system {name!r}: choose among {', '.join(PACKAGES)}")
    return cast("System", import_module(f"swarmproof.{PACKAGES[name]}.system").SYSTEM)


def reading_of(name: str) -> type[Reading]:
    """Return the open places of the system of this name, without loading the rest of it: for help and options."""
    return cast("type[Reading]", import_module(f"swarmproof.{PACKAGES[name]}.semantics").Semantics)
