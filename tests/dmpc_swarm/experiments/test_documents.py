"""The committed pages of full runs say what the cells beside them say, by the claims as they are now."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from swarmproof.campaign.decide import DecidedClaim, decide
from swarmproof.claims.samples import Label, Observation, Value
from swarmproof.dmpc_swarm.claims.experiments import claims_of
from swarmproof.dmpc_swarm.experiments.experiment import AS_CHOSEN
from swarmproof.dmpc_swarm.experiments.experiments import EXPERIMENTS
from swarmproof.dmpc_swarm.pages.experiments.page import shown

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "docs" / "experiments"
NUMBERED = ("cus", "jam_start", "jam_rounds", "uavs", "loss_percent")
WORDED = ("trigger", "formation", "method")


def rows(name: str) -> list[dict[str, str]]:
    """Return the rows of the committed cells of an experiment."""
    with (FOLDER / name / "cells.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def observation(row: dict[str, str]) -> Observation:
    """Return what a row says."""
    labels: dict[str, Label] = {label: int(row[label]) for label in NUMBERED if label in row}
    labels |= {label: row[label] for label in WORDED if label in row}
    other = {"variant", "cell", "seed", "command", *NUMBERED, *WORDED}
    return Observation(int(row["seed"]), labels, {key: value(text) for key, text in row.items() if key not in other})


def value(text: str) -> Value:
    """Return the value that is written as `text`."""
    return {"": None, "True": True, "False": False}[text] if text in ("", "True", "False") else float(text)


def decided(name: str, variant: str) -> Sequence[DecidedClaim]:
    """Return what the committed cells of a variant decide."""
    seen = [observation(row) for row in rows(name) if row["variant"] == variant]
    return [decide(claim, seen) for claim in claims_of(name)]


def cells_of(line: str) -> list[str]:
    """Return the texts in a line of a Markdown table."""
    return [text.strip() for text in line.strip().strip("|").split(" | ")]


def table(name: str, heading: str) -> Iterator[list[str]]:
    """Yield the rows of the table below a heading of the committed page."""
    text = (FOLDER / name / "README.md").read_text(encoding="utf-8")
    for line in text.split(f"## {heading}\n", 1)[1].split("\n## ", 1)[0].splitlines():
        if line.startswith(("| ✓", "| ✗", "| ?", "| `")):
            yield cells_of(line)


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_the_page_has_the_verdicts_of_its_cells(name: str) -> None:
    """Deciding from cells.csv gives each verdict and each reason on the page."""
    lines = list(table(name, "What the paper says, and what was flown"))
    for (verdict, _, why), each in zip(lines, decided(name, AS_CHOSEN), strict=True):
        assert verdict == f"{shown(each)} `{each.claim.id}`"
        assert why.startswith(each.why)


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_the_page_has_the_verdicts_of_each_choice(name: str) -> None:
    """The table of choices has a row for each variant, with the verdicts that its cells give."""
    lines = list(table(name, "Which of our choices matter"))
    variants = EXPERIMENTS[name](False).variants
    assert [line[0].split("`")[1] for line in lines] == [variant.name for variant in variants]
    for line, variant in zip(lines, variants, strict=True):
        for text, each in zip(line[2:], decided(name, variant.name), strict=True):
            assert text.replace("*", "").startswith(shown(each))


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_the_page_is_of_the_whole_experiment(name: str) -> None:
    """Every cell of the full experiment is there, with the command that flies it, and nothing else is."""
    there = {(row["variant"], row["cell"], row["command"]) for row in rows(name)}
    variants = EXPERIMENTS[name](False).variants
    assert there == {(variant.name, cell.id, cell.command) for variant in variants for cell in variant.cells}
    assert "Incomplete" not in (FOLDER / name / "README.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_the_readme_links_the_page(name: str) -> None:
    """The project's front page leads to each page and shows one of its pictures."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert f"(docs/experiments/{name}/README.md)" in text
    assert any(f"(docs/experiments/{name}/{picture.name})" in text for picture in (FOLDER / name).glob("*.png"))
