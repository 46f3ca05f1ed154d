"""The mutants that no test can kill, each with the sentence that proves that its answers are right: `equal.toml`."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path

TABLE = Path(__file__).with_name("equal.toml")


def read(text: str) -> dict[str, dict[str, str]]:
    """Return the sentence of each mutant by its name, by module; AssertionError if one is there twice, or empty."""
    found: dict[str, dict[str, str]] = {}
    for entry in tomllib.loads(text)["equal"]:
        assert entry.keys() == {"module", "mutants", "why"}
        assert entry["why"].endswith(".")
        of_module = found.setdefault(entry["module"], {})
        for name in entry["mutants"]:
            assert name not in of_module, f"twice: {name}"
            of_module[name] = entry["why"]
    return found


EQUAL: Mapping[str, Mapping[str, str]] = read(TABLE.read_text(encoding="utf-8"))
