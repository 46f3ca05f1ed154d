"""The report of a flight: it says every verdict, draws what was flown, stays small, and is the same every time."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.claims.flight import FLIGHT_CLAIMS
from swarmproof.dmpc_swarm.flight.judge import Flown, Judged
from swarmproof.dmpc_swarm.flight.log import Log, Logged, Outcome, moved
from swarmproof.dmpc_swarm.flight.run import Setting, fly
from swarmproof.dmpc_swarm.pages.flight.page import check_available, flight_page, inlined, put_flight
from swarmproof.dmpc_swarm.pages.flight.paths import PART, WHOLE, in_view, shown_rounds
from swarmproof.dmpc_swarm.pages.flight.plots import Picture, first_violations
from swarmproof.dmpc_swarm.pages.flight.separation import down_text, is_enlarged
from swarmproof.dmpc_swarm.pages.flight.series import (
    Band,
    Bins,
    distances_to_targets,
    jumps,
    lost_messages,
    pair_distance,
    sampled_separation,
    states_of_cus,
    target_changes,
)
from swarmproof.dmpc_swarm.pages.flight.timeline import MOST_MARKS
from swarmproof.dmpc_swarm.planner.planner import Planned
from swarmproof.dmpc_swarm.planner.problem import Task
from swarmproof.dmpc_swarm.protocol.algorithm1 import CuState
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.trigger import Trigger
from swarmproof.errors import BadInput, Failed
from swarmproof.faults.grammar import parse
from swarmproof.output import LISTED, ReportFolder
from swarmproof.qp.solvers import Status
from swarmproof.scenario.scenario import load

SVG = "{http://www.w3.org/2000/svg}"
#: A flight: setting, losses, verdicts, log.
Seen = tuple[Setting, str, Flown, Log]


@cache
def seen(
    scenario: str = "crossing", loss: str = "iid:0.2", preset: str = "guarded", rounds: int = 40, *changes: str
) -> Seen:
    """Fly once for all tests."""
    semantics = Semantics.parse(preset, ["initial=known", "event_trigger=round-robin"])
    setting = Setting(load(scenario, 0, changes), 2, Trigger.HT, semantics, 0)
    flight = setting.flight()
    log = Log(flight)
    losses = parse(loss, setting.scenario.uavs, setting.cus, setting.seed)
    flown, _ = fly(setting, losses, rounds, log.see, flight)
    return setting, loss, flown, log


def violating() -> Seen:
    """Return a flight without recovery, in which references come too close."""
    return seen("circle", "jam:2,12", "ignore-loss", 25, "uavs=8")


def report_of(flight: Seen) -> dict[str, str]:
    """Return what is written of a flight, by file."""
    with tempfile.TemporaryDirectory() as folder:
        write_flight(Path(folder), flight)
        return {path.name: path.read_text(encoding="utf-8") for path in Path(folder).iterdir() if path.name != LISTED}


def write_flight(folder: Path, flight: Seen) -> None:
    """Write the report of a flight into a folder."""
    with ReportFolder(folder) as report:
        put_flight(report, *flight)
        report.publish()


FLIGHTS: dict[str, Callable[[], Seen]] = {"quiet": seen, "violating": violating}


@cache
def drawn(name: str) -> dict[str, str]:
    """Write the report of one of :data:`FLIGHTS` once for all tests."""
    return report_of(FLIGHTS[name]())


def words_of(flight: Seen) -> str:
    """Return the page of a flight without pictures, which take the most time."""
    return flight_page(*flight, [])


def text_of(page: str) -> str:
    """Return a page's words without tags, spaces made single."""
    body = re.sub(r"<(style|svg)\b.*?</\1>", " ", page, flags=re.DOTALL)
    return re.sub(r"\s+", " ", unescape(re.sub(r"<[^>]+>", " ", body)))


def section_of(page: str, identifier: str) -> str:
    """Return the words of the row or section with this identifier."""
    found = re.search(rf'<(tr|section)[^>]*id="{identifier}".*?</\1>', page, re.DOTALL)
    assert found is not None, identifier
    return text_of(found[0])


def longer(flight: Seen, times: int) -> Seen:
    """Return a flight that goes on by being the same again, to draw a long one without flying it."""
    setting, loss, flown, log = flight
    rounds = len(log.rounds) * times
    logged = [
        one._replace(replanned=tuple(attempt._replace(k=k) for attempt in one.replanned))
        for k, one in zip(range(rounds), log.rounds * times, strict=True)
    ]
    return setting, loss, replace(flown, rounds=rounds, band=np.tile(flown.band, (times, 1))), Log(log.flight, logged)


@pytest.mark.parametrize("name", FLIGHTS)
def test_the_page_has_every_verdict(name: str) -> None:
    """Each claim has a row with its identifier, wording, place and verdict, red if and only if it is violated."""
    one = FLIGHTS[name]()
    page = words_of(one)
    for judged in one[2].claims:
        row = section_of(page, f"claim-{judged.claim.id}")
        for words in (judged.claim.id, judged.claim.wording, judged.claim.place, judged.why):
            assert re.sub(r"\s+", " ", words) in row
        assert {
            Verdict.VIOLATED: "✗ violated",
            Verdict.NOT_VIOLATED: "✓ not violated",
            Verdict.UNDECIDED: "? undecided",
            Verdict.NOT_APPLICABLE: "– not applicable",
        }[judged.verdict] in row
        tag = re.search(rf'id="claim-{judged.claim.id}".*?class="tag (\w+)"', page, re.DOTALL)
        assert tag is not None
        assert (tag[1] == "bad") == (judged.verdict is Verdict.VIOLATED)
    first, second = re.findall(r'<section class="(box(?: good)?)">\n<strong class="what">(.)', page)[:2]
    collided = any(judged.verdict is Verdict.VIOLATED and "eq-2" in judged.claim.id for judged in one[2].claims)
    assert first == (("box", "✗") if collided else ("box good", "✓"))
    assert (second == ("box good", "✓")) == (not one[2].violated)


def test_a_violation_is_told() -> None:
    """The chain of each violated claim is on the page, line by line, in a section that the claim's row links to."""
    flight = violating()
    page = words_of(flight)
    told = [judged for judged in flight[2].claims if judged.chain]
    assert told, "this flight should violate a claim about two trajectories"
    for judged in told:
        link = re.search(rf'id="claim-{judged.claim.id}".*?href="#(chain-[\w-]+)"', page, re.DOTALL)
        assert link is not None
        section = section_of(page, link[1])
        assert judged.claim.id in section
        for line in judged.chain:
            assert re.sub(r"\s+", " ", line) in section.replace(" :", ":")
    assert page.count("How it came about</h2>") == 1


def test_nothing_is_told_where_nothing_is_violated() -> None:
    """Without a violation there is no section about one."""
    assert not seen()[2].violated
    assert "How it came about" not in words_of(seen())


def test_the_page_escapes_what_it_is_given() -> None:
    """Words of the scenario and of the loss model cannot become elements of the page."""
    setting, _, flown, log = seen()
    scenario = replace(setting.scenario, name="<b>&evil</b>")
    page = words_of((replace(setting, scenario=scenario), "<i>loss</i>", flown, log))
    assert "<b>&evil" not in page
    assert "<i>loss" not in page
    assert "&lt;b&gt;&amp;evil" in page


@pytest.mark.parametrize("name", FLIGHTS)
def test_the_page_needs_nothing_else(name: str) -> None:
    """Nothing is fetched: whatever the page refers to is in it, by an identifier that occurs once."""
    page = drawn(name)["index.html"]
    for fetched in ("<link", "<script", "<img", "<iframe", "<object", "@import", " src="):
        assert fetched not in page
    identifiers = re.findall(r'\bid="([^"]*)"', page)
    assert len(identifiers) == len(set(identifiers))
    for target in re.findall(r'href="([^"]*)"', page) + re.findall(r"url\(([^)]*)\)", page):
        assert target.startswith("data:image/png;base64,") or target[1:] in identifiers, target
    assert page.count("<svg") == page.count('role="img" aria-label="') == 3


def test_pictures_are_well_formed() -> None:
    """Every picture is well-formed XML, beside the page and in it, with words for those who do not see it."""
    report = drawn("quiet")
    assert sorted(report) == ["index.html", "paths.svg", "separation.svg", "timeline.svg"]
    for name in sorted(report)[1:]:
        assert ElementTree.fromstring(report[name].encode()).tag == f"{SVG}svg"
    for drawing in re.findall(r"<svg.*?</svg>", report["index.html"], re.DOTALL):
        root = ElementTree.fromstring(drawing)
        assert len(root.attrib["aria-label"]) > 40
        assert "width" not in root.attrib


def test_a_description_cannot_break_the_picture() -> None:
    """What a picture shows, in words, is escaped."""
    picture = Picture("one", "One", f'<?xml version="1.0"?>\n<svg xmlns="{SVG[1:-1]}"/>', '"<&>', "")
    picture = replace(picture, svg=picture.svg.replace("/>", "></svg>"))
    assert ElementTree.fromstring(inlined(picture)).attrib["aria-label"] == '"<&>'


def test_the_same_flight_gives_the_same_bytes() -> None:
    """Page and pictures are the same when they are drawn again, whatever matplotlib's settings, and bear no date."""
    import matplotlib

    with matplotlib.rc_context({"font.size": 30, "svg.hashsalt": "other"}):
        assert report_of(seen()) == drawn("quiet")
    assert not any(re.search(r"20\d\d-\d\d-\d\d", content) for content in drawn("quiet").values())


def test_other_flights_give_other_pictures() -> None:
    """Every picture depends on the flight: under other losses, each is another. The log may lack the last round."""
    setting, loss, flown, log = seen("crossing", "none")
    interrupted = setting, loss, flown, Log(log.flight, log.rounds[:-1])
    assert all(content != drawn("quiet")[name] for name, content in report_of(interrupted).items())


def test_the_certified_minimum_is_in_the_band() -> None:
    """The drawn band has the certified minimum where the closest approach is, and contains all samples."""
    for _, _, flown, log in (seen(), violating(), seen("circle", "none", "guarded", 25, "uavs=8")):
        T_c = float(log.flight.scenario.parameters.T_c)
        band = Band.of(flown, T_c)
        assert band.steps == 1
        assert band.lower.min() == pytest.approx(flown.continuous_lower, rel=1e-2)
        assert band.lower.min() >= flown.continuous_lower
        assert band.upper.min() >= flown.continuous_lower
        assert np.all(band.lower <= band.upper)
        samples = sampled_separation(log)
        assert samples[:-1].min() == pytest.approx(flown.sampled, rel=1e-12)
        # each step contains the samples at its begin
        assert np.all(band.lower <= samples[:-1] * (1 + 1e-12))
        step = int(flown.closest_pair[1] / T_c)
        assert band.lower[step] == band.lower.min()


def test_a_thinned_band_keeps_the_minimum() -> None:
    """However few bins a long flight is drawn in, each bin has the extremes of its steps; bins cover the time."""
    _, _, flown, _ = longer(violating(), 40)
    whole = Band.of(flown, 0.1, most=10**6)
    for most in (1, 7, 100, 1999):
        thin = Band.of(flown, 0.1, most)
        assert len(thin.lower) == len(thin.upper) == len(thin.edges) - 1 <= most
        assert thin.lower.min() == whole.lower.min()
        assert thin.upper.min() == whole.upper.min()
        assert thin.highest.max() == whole.highest.max()
        assert (thin.edges[0], thin.edges[-1]) == (0.0, pytest.approx(0.1 * len(flown.band)))
        for k in range(len(thin.lower)):
            inside = slice(k * thin.steps, (k + 1) * thin.steps)
            assert thin.lower[k] == whole.lower[inside].min()
            assert thin.highest[k] == whole.highest[inside].max()
    # leaving steps out, as thinning must not, would miss the minimum
    assert flown.band[1::2, 0].min() > whole.lower.min() or flown.band[::2, 0].min() > whole.lower.min()


def test_bins() -> None:
    """Bins are as few entries wide as possible, and the last one is what is left over."""
    values = np.array([5.0, 1, 4, 2, 9, 7, 3])
    bins = Bins.of(7, 3)
    assert (bins.width, bins.starts.tolist(), bins.edges(0.5).tolist()) == (3, [0, 3, 6], [0, 1.5, 3, 3.5])
    assert bins.least(values).tolist() == [1, 2, 3]
    assert bins.largest(values).tolist() == [5, 9, 3]
    assert bins.mean(np.stack([values, 2 * values], axis=1)).tolist() == [[10 / 3, 20 / 3], [6, 12], [3, 6]]
    assert (Bins.of(7, 7).width, Bins.of(8, 7).width, Bins.of(1, 7).starts.tolist()) == (1, 2, [0])


def test_the_log_is_the_flight() -> None:
    """Positions of the log are those of the flown references, at samples and between, until the end of the flight."""
    _, _, flown, log = seen()
    lattice = log.flight.lattice
    unit = float(lattice.position_unit)
    positions = log.positions(lattice.steps)
    assert positions.shape == (len(log.rounds) * lattice.steps + 1, 2, 3)
    state = log.flight.initial()
    for i in range(2):
        np.testing.assert_array_equal(positions[0, i], state.followed(i).sampled_from(0)[0] * unit)
    # nothing jumps in a guarded flight, so the end of a round is where the next one begins
    ends = np.array([moved(logged.motion, lattice.steps) for logged in log.rounds])
    np.testing.assert_array_equal(ends[:-1] * unit, positions[lattice.steps : -1 : lattice.steps])
    np.testing.assert_array_equal(ends[-1] * unit, positions[-1])
    np.testing.assert_array_equal(log.positions(4, 5, 9)[::2], positions[10:19])
    np.testing.assert_allclose(log.at(1.3), positions[13], atol=1e-12)
    np.testing.assert_allclose(log.at(flown.rounds * 0.2), positions[-1], atol=1e-12)
    (i, j), time = flown.closest_pair
    apart = (log.at(time)[j] - log.at(time)[i]) * (1, 1, 1 / 6)
    assert np.linalg.norm(apart) == pytest.approx(flown.continuous_lower, rel=1e-6)


def test_the_closest_pair_is_the_closest() -> None:
    """The distance of the closest pair is nowhere below the certified bound, and comes as close to it as is drawn."""
    _, _, flown, log = violating()
    pair, time = flown.closest_pair
    k = int(time / 0.2)
    curve = pair_distance(log, pair, 1000, k, k + 1)
    assert flown.continuous_lower <= curve.min() <= flown.continuous_lower * (1 + 1e-4)
    assert 0.2 * (k + curve.argmin() / 1000) == pytest.approx(time, abs=1e-3)


def test_what_happened_is_counted_right() -> None:
    """Losses, attempts and states of the log add up to what the judge counted, and to what the page says."""
    setting, _, flown, log = seen()
    assert lost_messages(log).sum() == flown.lost > 0
    outcomes = [attempt.outcome for logged in log.rounds for attempt in logged.replanned]
    assert outcomes.count(Outcome.ADOPTED) + outcomes.count(Outcome.NOT_ADOPTED) == flown.qps.solved
    assert outcomes.count(Outcome.REJECTED) == flown.qps.rejected
    assert outcomes.count(Outcome.INFEASIBLE) == flown.qps.infeasible
    assert outcomes.count(Outcome.NOT_ADOPTED) > 0, "some plan should be lost"
    states = states_of_cus(log)
    assert np.all(states.sum(axis=2) == 1)
    assert states[..., CuState.RUN_DMPC].sum() == sum(s is CuState.RUN_DMPC for one in log.rounds for s in one.states)
    page = words_of(seen())
    for w in range(setting.cus):
        row = re.search(rf"<tr><td>CU {w}</td>(.*?)</tr>", page, re.DOTALL)
        assert row is not None
        counts = [int(count) for count in re.findall(r">(\d+)<", row[1])]
        mine = [one.outcome for logged in log.rounds for one in logged.replanned if one.cu == w]
        assert counts == [*states[:, w].sum(axis=0).astype(int), *(mine.count(one) for one in Outcome)]


class _Failing:
    """A planner that has no plan, for one of two reasons."""

    def plan(self, task: Task) -> Planned:
        """Return no plan."""
        status = Status.INFEASIBLE if task.i else Status.GAVE_UP
        return Planned(None, status, f"<no> plan of UAV {task.i}", True)


def test_attempts_without_a_plan_are_listed() -> None:
    """Rejected and infeasible attempts are told apart and listed with the reason; a long list is cut and says so."""
    setting = seen()[0]
    flight = setting.flight(_Failing())
    log = Log(flight)
    flown, _ = fly(setting, parse("none", 2, 2, 0), 10, log.see, flight)
    words = text_of(words_of((setting, "none", flown, log)))
    assert {(one.uav, one.outcome) for logged in log.rounds for one in logged.replanned} == {
        (0, Outcome.REJECTED),
        (1, Outcome.INFEASIBLE),
    }
    assert "for UAV 0 (rejected): <no> plan of UAV 0" in words
    assert "for UAV 1 (infeasible): <no> plan of UAV 1" in words
    assert "… and 8 more" in words
    assert flown.undecided
    assert re.search(r"our planner found no plan in (\d+) of \1 feasible problems", words)
    assert "No claim was violated in this flight, but 1 claim could not be decided" in words


def test_jumps_are_seen() -> None:
    """A reference jumps only where a plan began elsewhere: never with recovery; a caption says so."""
    assert jumps(seen()[3]) == 0
    assert jumps(violating()[3]) > 0
    assert "some reference jumps" in drawn("violating")["index.html"]
    assert "some reference jumps" not in drawn("quiet")["index.html"]


def test_targets_and_arrival() -> None:
    """Distances to targets shrink to nothing in a flight that arrives, and target changes are those of the scenario."""
    setting, _, flown, log = seen("crossing", "none", "guarded", 40)
    distances = distances_to_targets(log, setting.scenario)
    assert distances.shape == (40, 2)
    assert flown.arrived
    assert distances[0].min() > 1
    assert distances[-1].max() < 0.05
    assert target_changes(load("formations"), 400) == [0, 110, 220, 330]
    assert target_changes(load("formations"), 110) == [0]
    assert target_changes(load("random"), 226) == [0, 75, 150, 225]


def test_violations_are_marked_when_they_happen() -> None:
    """A line marks the first violation of a claim about rounds; a claim about the whole flight has no such time."""
    _, _, flown, _ = violating()
    times = first_violations(flown, 0.2)
    broken = {judged.rounds for judged in flown.claims if judged.verdict is Verdict.VIOLATED}
    assert times == [pytest.approx(0.2 * k) for k in sorted(k for k in broken if k is not None)]
    arrives = next(claim for claim in FLIGHT_CLAIMS if claim.id == "arrives")
    late = Judged(arrives, Verdict.VIOLATED, "late", rounds=25)
    assert first_violations(replace(flown, claims=(late,)), 0.2) == []
    assert first_violations(seen()[2], 0.2) == []


def test_a_dip_is_enlarged_if_it_is_small() -> None:
    """References that dip a little below d̂_min are drawn enlarged, those far away from it or far below it are not."""
    _, _, flown, _ = seen()
    for lowest, enlarged in ((0.2499, True), (0.21, True), (0.26, True), (0.19, False), (0.3, False), (0.0, False)):
        band = np.array([[lowest, lowest + 1e-3], [0.5, 0.5]])
        assert is_enlarged(replace(flown, band=band), 0.25) is enlarged


def test_bounds_are_rounded_down() -> None:
    """A lower bound on the page is not above the one that was certified."""
    assert (down_text(0.2495829), down_text(0.25)) == ("0.249582", "0.250000")


def test_a_long_flight_shows_rounds_around_the_closest_approach() -> None:
    """A short flight has colours from begin to end, a long one for the rounds around its closest approach."""
    assert shown_rounds(WHOLE, 3) == range(WHOLE)
    for k in (0, 50, 1000, 4999):
        shown = shown_rounds(5000, k)
        assert len(shown) == PART
        assert k in shown
        assert 0 <= shown.start <= shown.stop <= 5000
    assert shown_rounds(5000, 1000) == range(1000 - PART // 2, 1000 + PART // 2)


def test_a_space_that_is_far_larger_than_the_paths_is_shown_in_part() -> None:
    """Of an open space, the part around the UAVs is drawn, in which their paths can be seen; of a small one, all."""
    path = np.array([[500_000, 900_000, 1.5], [500_001, 900_004, 1.5]])
    small = np.array([[499_990, 899_990, 0], [500_010, 900_010, 3.0]])
    assert np.array_equal(in_view(small, path), small)
    for open_space in ([[-3e7, -3e7, 0], [3e7, 3e7, 30]], [[499_999, 899_000, 0], [500_009, 3e7, 30]]):
        low, high = shown = in_view(np.array(open_space, float), path)
        assert ((low <= path) & (path <= high)).all()
        assert ((low >= open_space[0]) & (high <= open_space[1])).all()
        assert (high - low).max() < 2 * 4, shown


def test_a_long_flight_is_small() -> None:
    """A page of 10,000 rounds has less than 3 MB, well-formed pictures, and says that it is thinned out."""
    flight = longer(seen("circle", "iid:0.1", "guarded", 40, "uavs=8"), 250)
    assert sum(len(logged.replanned) for logged in flight[3].rounds) > MOST_MARKS
    report = report_of(flight)
    assert len(report["index.html"].encode()) < 3_000_000
    assert report["index.html"].count("The flight is long") == 3
    for name in ("paths.svg", "separation.svg", "timeline.svg"):
        ElementTree.fromstring(report[name].encode())
    # the paths of all other rounds: one image for each view
    assert report["paths.svg"].count("data:image/png") == 2


def test_the_shortest_flight_can_be_drawn() -> None:
    """A flight of one round has a page; with tracking errors, it says how far UAVs may be from references."""
    report = report_of(seen("crossing", "iid:0.9", "guarded", 1, "tracking_error=0.02"))
    assert "may be up to 0.02 m away from these references" in text_of(report["index.html"])
    assert "away from these references" not in text_of(drawn("quiet")["index.html"])


def test_the_log_sees_one_round_at_a_time() -> None:
    """What is kept of a round is complete: an interrupt cannot leave half of one behind."""
    log = seen()[3]
    assert all(isinstance(logged, Logged) for logged in log.rounds)
    assert len(log.rounds) == 40
    assert [one.k for logged in log.rounds for one in logged.replanned] == sorted(
        k for k, logged in enumerate(log.rounds) for _ in logged.replanned
    )


def test_without_matplotlib_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Where matplotlib is missing, one sentence says how to install it, before the flight and after."""
    flight = seen()
    check_available()
    for module in ("matplotlib", "matplotlib.figure"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(BadInput, match=r"pip install 'swarmproof\[plots\]'$"):
        check_available()
    with pytest.raises(BadInput, match=r"pip install 'swarmproof\[plots\]'$"):
        write_flight(tmp_path, flight)
    assert not list(tmp_path.iterdir())


def test_importing_the_page_does_not_import_matplotlib() -> None:
    """Flights without a report neither need matplotlib nor wait for it."""
    code = "import sys, swarmproof.dmpc_swarm.pages.flight.page; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    """Where a file cannot be written, one sentence says so."""
    (tmp_path / "paths.svg").mkdir()
    with pytest.raises(Failed, match="cannot be written: Is a directory"):
        write_flight(tmp_path, seen())
