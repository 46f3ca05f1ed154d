"""The matrix as a report: one table over all configurations, and a folder with pages and traces for each."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from swarmproof.campaign.matrix import RowResult, in_short
from swarmproof.formats.verdicts import as_json
from swarmproof.output import ReportFolder
from swarmproof.pages.page import template
from swarmproof.pages.verification import put_result

SCHEMA = "swarmproof.matrix/1"


class MatrixJson(msgspec.Struct):
    """All configurations with their verdicts, and which of these changed."""

    schema: str
    configurations: list[msgspec.Raw]
    changed: dict[str, list[str]]


def matrix_json(results: Sequence[RowResult]) -> bytes:
    """Return the matrix as an indented JSON document: the verdicts of each configuration, and the changes."""
    document = MatrixJson(
        SCHEMA,
        [msgspec.Raw(as_json(one.result, {})) for one in results],
        {one.row.name: one.changes for one in results if one.changes},
    )
    return msgspec.json.format(msgspec.json.encode(document), indent=2) + b"\n"


def matrix_page(results: Sequence[RowResult]) -> str:
    """Return the page that compares all configurations; it links to a folder for each, named as the configuration."""
    return template("matrix.html.j2").render(
        system=results[0].row.system.name if results else "nothing",
        claims=[decided.claim for decided in results[0].result.claims] if results else [],
        results=results,
        in_short=in_short,
        changed=sum(1 for one in results if one.changes),
    )


def put_matrix(folder: ReportFolder, results: Sequence[RowResult]) -> None:
    """Put the matrix, and for each configuration a folder with its pages and traces, into `folder`."""
    for one in results:
        put_result(folder, one.result, within=f"{one.row.name}/")
    folder.put("matrix.json", matrix_json(results))
    folder.put("index.html", matrix_page(results))
