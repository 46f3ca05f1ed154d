"""The page about an experiment says what its flights say: every verdict, all numbers, what is missing, what changed."""

from __future__ import annotations

import csv
import math
import random
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from html import unescape
from pathlib import Path
from statistics import median

import pytest

from swarmproof.campaign.decide import decide_variant
from swarmproof.campaign.store import Stored
from swarmproof.campaign.trial import Cell
from swarmproof.dmpc_swarm.claims.experiments import FORMATIONS, IGNORING, MLR, claims_of
from swarmproof.dmpc_swarm.experiments.experiment import Experiment, Variant
from swarmproof.dmpc_swarm.experiments.experiments import EXPERIMENTS
from swarmproof.dmpc_swarm.experiments.measure import RADII, REACHED, Leg, Measured
from swarmproof.dmpc_swarm.pages.experiments.formations_plots import arrivals, total
from swarmproof.dmpc_swarm.pages.experiments.numbers import Data, counted, distances, times
from swarmproof.dmpc_swarm.pages.experiments.page import put_reproduction, shown
from swarmproof.dmpc_swarm.pages.experiments.plots import pictures
from swarmproof.dmpc_swarm.pages.experiments.tables import tables
from swarmproof.output import ReportFolder

Found = Mapping[Cell, Stored]


def made_up(cell: Cell, unsafe: bool = False) -> Stored:
    """Return numbers that a flight could have; the same for the same cell. `unsafe`: MLR-DMPC collides as well."""
    draw = random.Random(cell.id)
    number = len(FORMATIONS) if cell.scenario == "formations" else 1
    uavs = next((int(one[5:]) for one in cell.changes if one.startswith("uavs=")), 16)
    collides = draw.random() < 0.4 and (unsafe or cell.preset == "ignore-loss")
    lower = draw.uniform(0.02, 0.11) if collides else draw.uniform(0.2, 0.26)
    start = int(cell.loss[4:].split(",")[0]) if cell.loss.startswith("jam") else 0
    rounds = cell.rounds // number
    return Stored(
        Measured(
            rounds=cell.rounds,
            sampled=lower,
            lower=lower,
            collides=collides,
            closest=(1, 2),
            closest_time=draw.uniform(0, 9),
            lost=draw.randrange(99),
            solved=90,
            rejected=2,
            infeasible=1,
            all_plan=draw.randrange(cell.rounds),
            all_run=cell.rounds,
            adopted=80,
            last_adopted=40,
            rest_from=start + 16,
            violated=("eq-2", "theorem-2") if collides else (),
            legs=tuple(made_up_leg(draw, which * rounds, rounds, uavs, cell.series) for which in range(number)),
        ),
        draw.uniform(1, 9),
    )


def made_up_leg(draw: random.Random, begin: int, rounds: int, uavs: int, series: bool) -> Leg:
    """Return a leg that could be: in a tenth of all, one UAV never arrives."""
    arrived: list[int | None] = [draw.randrange(20, 60) for _ in range(uavs)]
    if draw.random() < 0.1:
        arrived[-1] = None
    last = None if None in arrived else max(one for one in arrived if one is not None)
    falling = tuple(2.0 * 0.95**k for k in range(rounds)) if series else ()
    return Leg(
        begin,
        rounds,
        tuple(last for _ in RADII),
        tuple(tuple(arrived) for _ in RADII),
        largest=falling,
        mean=tuple(one / 2 for one in falling),
        smallest=tuple(0.0 for _ in falling),
    )


def with_variant(experiment: Experiment, name: str, change: Callable[[Cell], Cell]) -> Experiment:
    """Return the experiment with a variant more, of the same flights with something changed."""
    cells = tuple(change(cell) for cell in experiment.variants[0].cells)
    return replace(experiment, variants=(*experiment.variants, Variant(name, "something else", cells)))


def two_variants(name: str) -> Experiment:
    """Return the quick experiment, and a variant with other seeds."""
    return with_variant(EXPERIMENTS[name](True), "retry=0", lambda cell: replace(cell, seed=cell.seed + 1000))


def flown_but_one(experiment: Experiment) -> dict[Cell, Stored]:
    """Return made-up results of all cells as chosen but one."""
    return {cell: made_up(cell) for cell in experiment.variants[0].cells[:-1]}


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, tuple[Path, Experiment, Found]]:
    """Return a page for each experiment: quick, a flight missing as chosen, a variant that was not flown."""
    pages = {}
    for name in EXPERIMENTS:
        folder, experiment = tmp_path_factory.mktemp(name), two_variants(name)
        found = flown_but_one(experiment)
        write_reproduction(folder, experiment, found, quick=True)
        pages[name] = folder, experiment, found
    return pages


def write_reproduction(folder: Path, experiment: Experiment, found: dict[Cell, Stored], quick: bool) -> None:
    """Write the page into a folder."""
    with ReportFolder(folder) as report:
        put_reproduction(report, experiment, found, quick)
        report.publish()


def html_of(folder: Path) -> str:
    """Return the HTML page without tags and line breaks."""
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", (folder / "index.html").read_text(encoding="utf-8"))).split())


def markdown_of(folder: Path) -> str:
    """Return the Markdown page."""
    return (folder / "README.md").read_text(encoding="utf-8")


def rows_below(text: str, heading: str) -> list[list[str]]:
    """Return the rows of the first Markdown table below a heading, without the two of its head."""
    lines = text.split(f"# {heading}\n", 1)[1].splitlines()
    begin = next(n for n, line in enumerate(lines) if line.startswith("|"))
    end = next((n for n, line in enumerate(lines) if n > begin and not line.startswith("|")), len(lines))
    return [[one.strip() for one in line.strip("|").split(" | ")] for line in lines[begin + 2 : end]]


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_every_claim_is_there_with_its_verdict(
    written: Mapping[str, tuple[Path, Experiment, Found]], name: str
) -> None:
    """Both pages have every claim: what the paper says, where, how it is read, the verdict and why."""
    folder, experiment, found = written[name]
    decided = decide_variant(experiment, experiment.variants[0], found)
    assert [each.claim for each in decided] == list(claims_of(name))
    pages = html_of(folder), " ".join(markdown_of(folder).split())
    for each in decided:
        for page in pages:
            assert f"{each.claim.wording} " in page
            assert each.claim.place in page
            assert each.claim.reading in page
            assert each.why in page
        assert f"{shown(each)} {each.claim.id} {each.claim.wording}" in pages[0]
        assert f"| {shown(each)} `{each.claim.id}` | {each.claim.wording}" in pages[1]


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_quick_and_incomplete_are_said(written: Mapping[str, tuple[Path, Experiment, Found]], name: str) -> None:
    """The headline says that a run is quick; how many flights are missing is said; so is a variant without flights."""
    folder, experiment, found = written[name]
    incomplete = f"Incomplete: {len(found)} of {len(experiment.cells)} flights"
    html, markdown = html_of(folder), markdown_of(folder)
    assert markdown.startswith(f"# {experiment.title}: a quick run\n")
    assert f"{experiment.title}: a quick run" in html
    assert incomplete in html
    assert incomplete in markdown
    *_, missing = rows_below(markdown, "Which of our choices matter")
    assert missing[0].startswith("`retry=0`")
    assert missing[1] == "0 (0)"
    assert set(missing[2:]) == {"– not flown"}


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_both_pages_have_the_same_verdicts_of_all_variants(
    written: Mapping[str, tuple[Path, Experiment, Found]], name: str
) -> None:
    """HTML and Markdown agree on every cell of the matrix of choices, and with what is decided."""
    folder, experiment, found = written[name]
    table = (folder / "index.html").read_text(encoding="utf-8").rpartition("<table>")[2].partition("</table>")[0]
    html = [
        [" ".join(unescape(re.sub(r"<[^>]+>", " ", one)).split()) for one in re.findall(r"<td[^>]*>(.*?)</td>", row)]
        for row in re.findall(r"<tr><td>.*?</tr>", table, re.DOTALL)
    ]
    markdown = [
        [one.replace("**", "").replace("`", "") for one in row]
        for row in rows_below(markdown_of(folder), "Which of our choices matter")
    ]
    assert [row[1:] for row in html] == [row[1:] for row in markdown]
    for row, variant in zip(markdown, experiment.variants, strict=True):
        decided = decide_variant(experiment, variant, found)
        flown = any(cell in found for cell in variant.cells)
        for text, each in zip(row[2:], decided, strict=True):
            assert text.startswith(shown(each) if flown else "– not flown")


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_pictures_are_beside_the_page(written: Mapping[str, tuple[Path, Experiment, Found]], name: str) -> None:
    """Every picture that the pages show is there, is a PNG 1000 to 1600 pixels wide, and has less than 300 kB."""
    folder, _, _ = written[name]
    linked = re.findall(r'<img src="([^"]+)"', (folder / "index.html").read_text(encoding="utf-8"))
    assert linked
    assert linked == re.findall(r"!\[[^]]*\]\(([^)]+)\)", markdown_of(folder))
    assert set(linked) == {path.name for path in folder.glob("*.png")}
    for one in linked:
        png = (folder / one).read_bytes()
        assert png.startswith(b"\x89PNG\r\n\x1a\n")
        assert 1000 <= int.from_bytes(png[16:20]) <= 1600
        assert len(png) < 300_000


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_cells_are_written_with_all_digits(written: Mapping[str, tuple[Path, Experiment, Found]], name: str) -> None:
    """Read back, `cells.csv` has exactly what was observed, in the order of the variant, with cell and command."""
    folder, experiment, found = written[name]
    with (folder / "cells.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    observed = [
        (cell, seen)
        for cell in experiment.variants[0].cells
        if cell in found
        for seen in experiment.observe(cell, found[cell].measured, REACHED)
    ]
    assert len(rows) == len(observed)
    for row, (cell, seen) in zip(rows, observed, strict=True):
        assert (row["variant"], row["cell"], row["command"]) == ("as chosen", cell.id, cell.command)
        assert row["seed"] == str(seen.seed)
        assert all(row[label] == str(value) for label, value in seen.labels.items())
        for value, number in seen.values.items():
            if isinstance(number, float):
                assert float(row[value]) == number
            else:
                assert row[value] == ("" if number is None else str(number))


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_tables_of_markdown_are_whole(written: Mapping[str, tuple[Path, Experiment, Found]], name: str) -> None:
    """No text breaks a Markdown table: all rows of a table have as many columns as its head."""
    folder, _, _ = written[name]
    columns = 0
    for line in markdown_of(folder).splitlines():
        if not line.startswith("|"):
            columns = 0
            continue
        number = len(re.findall(r"(?<!\\)\|", line))
        assert number == (columns or number), line
        columns = number


def test_the_flight_that_shows_a_verdict_can_be_flown(
    written: Mapping[str, tuple[Path, Experiment, Found]],
) -> None:
    """Beside what happened stands the cell in which UAVs come closest, with its command."""
    folder, _, found = written["fig4"]
    later = [cell for cell in found if cell.preset == "ignore-loss" and not cell.loss.startswith("jam:0,")]
    closest = min(later, key=lambda cell: found[cell].measured.lower)
    assert found[closest].measured.collides, "these made-up numbers show nothing: choose others"
    (line,) = (one for one in markdown_of(folder).splitlines() if "| ✓ agrees `fig4-ignoring-collides-later`" in one)
    assert f"Cell {closest.id}: `{closest.command}`" in line
    assert f"Cell {closest.id}: {closest.command} " in html_of(folder)


def test_a_choice_that_contradicts_is_marked(tmp_path: Path) -> None:
    """A variant in which MLR-DMPC collides contradicts; one that lacks flights leaves open, and is not marked."""
    experiment = with_variant(EXPERIMENTS["fig4"](True), "retry=0", lambda cell: replace(cell, seed=cell.seed + 1000))
    experiment = with_variant(experiment, "detours=off", lambda cell: replace(cell, seed=cell.seed + 2000))
    chosen, bad, few = experiment.variants
    found = {cell: made_up(cell) for cell in chosen.cells}
    found |= {cell: made_up(cell, unsafe=True) for cell in bad.cells}
    found |= {cell: made_up(cell) for cell in few.cells if cell.preset == "guarded"}
    write_reproduction(tmp_path, experiment, found, quick=False)
    rows = rows_below(markdown_of(tmp_path), "Which of our choices matter")
    place = 2 + [claim.id for claim in claims_of("fig4")].index("fig4-recovering-safe")
    assert rows[0][place] == "✓ not violated"
    assert rows[1][place] == "**✗ disagrees**"
    assert not any("**" in one for one in rows[2])
    html = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert html.count('changed"') == sum("**" in one for row in rows for one in row) > 0
    assert "quick" not in html_of(tmp_path).lower()


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_without_any_flight_the_page_says_so(tmp_path: Path, name: str) -> None:
    """An interrupted run may have no flight at all: there is a page, and it decides nothing."""
    experiment = EXPERIMENTS[name](True)
    write_reproduction(tmp_path, experiment, {}, quick=True)
    assert f"Incomplete: 0 of {len(experiment.cells)} flights" in html_of(tmp_path)
    tags = re.findall(r'class="tag ([a-z]+)"', (tmp_path / "index.html").read_text(encoding="utf-8"))
    assert set(tags) == {"dim"}


def test_pictures_are_the_same_every_time() -> None:
    """The same flights give the same bytes."""
    experiment = EXPERIMENTS["loss"](True)
    data = Data.of(experiment, experiment.variants[0], flown_but_one(experiment))
    assert [one.png for one in pictures(data)] == [one.png for one in pictures(data)]


def many_seeds(name: str, seeds: int) -> Data:
    """Return made-up flights of an experiment's quick cells, with so many seeds."""
    experiment = EXPERIMENTS[name](True)
    of_one = [cell for cell in experiment.variants[0].cells if cell.seed == 0]
    cells = tuple(replace(cell, seed=seed) for seed in range(seeds) for cell in of_one)
    variant = replace(experiment.variants[0], cells=cells)
    return Data.of(replace(experiment, variants=(variant,)), variant, {cell: made_up(cell) for cell in cells})


def row_of(data: Data, title: str, name: str) -> Sequence[str]:
    """Return the row of this name in the table of this title."""
    (table,) = [one for one in tables(data) if one.title == title]
    (row,) = [one for one in table.rows if one[0] == name]
    return row[1:]


def test_times_in_tables_are_medians_over_seeds() -> None:
    """Eight seeds: the median, and from the smallest to the largest, which is the 95 % interval of so few."""
    data = many_seeds("fig3b", 8)
    row = row_of(data, "Time to target: all UAVs there at once", "2 CUs, HT")
    for text, which in zip(row, range(len(FORMATIONS)), strict=True):
        rounds = [
            stored.measured.legs[which].all_within[RADII.index(REACHED)]
            for cell, stored in data.cells.items()
            if cell.cus == 2
        ]
        reached = sorted(0.2 * one for one in rounds if one is not None)
        if len(reached) == 8:
            assert text == f"{(reached[3] + reached[4]) / 2:.1f} s ({reached[0]:.1f} … {reached[-1]:.1f})"
        else:
            assert text.endswith(f"… ∞); {8 - len(reached)} of 8 not reached")


def test_collisions_in_tables_are_counted_by_flight_and_by_seed() -> None:
    """Flights of one seed are one repetition: the interval is of seeds."""
    data = many_seeds("fig4", 7)
    flights = {cell: one for cell, one in data.cells.items() if cell.preset == "ignore-loss"}
    hit = [cell for cell, one in flights.items() if one.measured.collides]
    title = next(one.title for one in tables(data) if one.title.startswith("Jams that end"))
    row = row_of(data, title, f"10 rounds (2.0 s), {IGNORING}")
    assert row[0] == f"{len(hit)} of {len(flights)}"
    assert row[1] == counted(len({cell.seed for cell in hit}), 7)
    assert row_of(data, title, f"10 rounds (2.0 s), {MLR}")[1] == "0 of 7 (0 … 41 %)"
    least = min(one.measured.lower for one in flights.values())
    assert row[2].endswith(f"least {math.floor(1000 * least) / 1000:.3f}")


@pytest.mark.parametrize(("preset", "method"), [("guarded", MLR), ("ignore-loss", IGNORING)])
def test_the_table_of_loss_has_each_method_by_itself(preset: str, method: str) -> None:
    """Collisions, smallest separation and rounds in which all CUs plan are those of the flights of one condition."""
    data = many_seeds("loss", 8)
    flights = [
        one.measured
        for cell, one in data.cells.items()
        if (cell.preset, cell.loss, "uavs=10" in cell.changes) == (preset, "iid:0.05", True)
    ]
    row = row_of(data, method, "10 UAVs, 5 %")
    assert len(flights) == 8
    assert row[0] == counted(sum(one.collides is True for one in flights), 8)
    assert row[1].endswith(f"least {math.floor(1000 * min(one.lower for one in flights)) / 1000:.3f}")
    planned = [100 * one.all_plan / one.rounds for one in flights]
    assert row[3] == f"{median(planned):.1f} % ({min(planned):.1f} … {max(planned):.1f})"


def test_numbers_are_written_honestly() -> None:
    """Separations are rounded down; few seeds have no interval; what never happened is counted; nothing is a dash."""
    assert distances([0.1199999, 0.3]) == "0.209 m; least 0.119"
    assert times([4.0, 8.0]) == "6.0 s"
    assert times([1.0, *[math.inf] * 6]) == "not reached (1.0 … ∞); 6 of 7 not reached"
    assert times([]) == distances([]) == counted(0, 0) == "–"
    assert counted(0, 20) == "0 of 20 (0 … 17 %)"


def test_arrivals_are_medians_of_each_arrival() -> None:
    """The k-th arrival is the median over flights of the k-th, infinite if the k-th mostly did not arrive."""

    def leg(*rounds: int | None) -> Leg:
        return Leg(0, 100, (None,) * len(RADII), tuple(rounds if one == REACHED else (1,) * 3 for one in RADII))

    legs = [leg(30, 10, None), leg(None, 20, 40), leg(None, 35, 15)]
    assert arrivals(legs) == pytest.approx([0.2 * 15, 0.2 * 35, math.inf])


def test_the_total_time_is_the_sum_of_medians() -> None:
    """It is what the caption says; if a formation is mostly not reached there is no sum, without flights no number."""
    data = many_seeds("fig3b", 3)
    one = [
        median(numbers)
        for which in range(len(FORMATIONS))
        if (
            numbers := [
                math.inf if rounds is None else 0.2 * rounds
                for cell, stored in data.cells.items()
                if cell.cus == 1
                for rounds in [stored.measured.legs[which].all_within[RADII.index(REACHED)]]
            ]
        )
    ]
    assert total(data, 1, "HT") == ("not all reached" if math.isinf(sum(one)) else f"{sum(one):.1f} s")
    assert total(data, 7, "HT") == "unknown"
