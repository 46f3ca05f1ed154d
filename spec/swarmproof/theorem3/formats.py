"""Which format a file is in that should be TOML but is not: for one sentence that says what to write instead."""

from __future__ import annotations

import json
import re

#: A line of YAML: ``name: value``, ``- item``, or the mark of a document. (The value of a TOML line follows a ``=``.)
_YAML = re.compile(r"(?:---.*|- .*|[\w\-\"'/]+\s*:(?:\s.*)?)")
_CSV = re.compile(r"[^=;,\t]*(?:[;,\t][^=;,\t]*){2,}")
_INI = re.compile(r"[\w.\-]+\s*[=:].*|\[[^\]]+\]")


def format_of(text: str) -> str | None:
    """Return the name of the format in which `text`, which is no TOML, seems to be; None if it is none of those known.

    (JSON is recognised for certain, the others by their first lines, up to 20 of them.)
    """
    stripped = text.lstrip("\ufeff \t\r\n")
    if stripped[:1] in ("{", "["):
        try:
            json.loads(stripped)
        except RecursionError:
            return "JSON"
        except ValueError:
            # comments and trailing commas are what dialects of JSON have beyond it
            if re.match(r"\{\s*(?:\"[^\"]*\"|\w+)\s*:", re.sub(r"//.*", "", stripped)):
                return "a kind of JSON"
        else:
            return "JSON"
    if re.match(r"<(?:\?xml|!--|[A-Za-z])", stripped):
        return "XML"
    if stripped.startswith("%YAML"):
        return "YAML"
    lines = [line.strip() for line in stripped.splitlines()]
    lines = [line for line in lines if line and not line.startswith(("#", ";", "//"))][:20]
    for name, form in (("YAML", _YAML), ("CSV", _CSV), ("an INI file", _INI)):
        # one line that is not such a line is for the one that was mistyped
        if lines and sum(form.fullmatch(line) is None for line in lines) <= len(lines) // 10:
            return name
    return None
