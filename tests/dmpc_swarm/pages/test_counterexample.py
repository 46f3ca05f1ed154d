"""The pages of a report: they need nothing but themselves, and say and draw what the run does."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from functools import cache
from html import unescape

import pytest

from swarmproof.claims.claim import Recovers
from swarmproof.claims.verdict import Verdict
from swarmproof.dmpc_swarm.pages import names
from swarmproof.dmpc_swarm.pages.causes import what_is_false
from swarmproof.dmpc_swarm.pages.diagram import sequence_diagram
from swarmproof.dmpc_swarm.pages.explain import explain_in
from swarmproof.dmpc_swarm.pages.story import tell
from swarmproof.dmpc_swarm.pages.swarm_run import SwarmRun
from swarmproof.dmpc_swarm.protocol.messages import HOVERING, Metadata, Trajectory
from swarmproof.dmpc_swarm.protocol.swarm import compute
from swarmproof.dmpc_swarm.semantics import Semantics
from swarmproof.dmpc_swarm.system import swarm as scope
from swarmproof.explore.decide import Decided, Result, verify
from swarmproof.pages import phrases
from swarmproof.pages.page import counterexample_page, overview_page
from swarmproof.trace.replay import Replay, replay

#: Readings of the paper that show every kind of page: conflicts, losses, a lasso, a selection, no recovery.
READINGS = [
    ("printed", ""),
    ("printed", "initial=known"),
    ("printed", "slot_conflict=cu-wins"),
    ("ignore-loss", ""),
    ("ignore-loss", "event_trigger=round-robin"),
]


@cache
def verified(preset: str, override: str, uavs: int = 2, cus: int = 2) -> Result:
    """Verify once for all tests."""
    return verify(scope(uavs, cus, Semantics.parse(preset, [override] if override else [])))


def shown(result: Result) -> list[tuple[Decided, Replay]]:
    """Return every claim with a run, and the run."""
    return [(one, replay(one.trace)) for one in result.claims if one.trace is not None]


def pages_of(preset: str, override: str) -> list[tuple[Decided, Replay, str]]:
    """Return every page of a verification."""
    result = verified(preset, override)
    return [(one, run, counterexample_page(one, run, result)) for one, run in shown(result)]


def text_of(page: str) -> str:
    """Return a page's words without tags, spaces made single."""
    body = re.sub(r"<style>.*?</style>", " ", page, flags=re.DOTALL)
    return re.sub(r"\s+", " ", unescape(re.sub(r"<[^>]+>", " ", body)))


def assert_self_contained(page: str) -> None:
    """Assert that a page asks for no other file, nor for the network."""
    assert page.startswith("<!DOCTYPE html>")
    for fetched in (
        "http:",
        "https:",
        "//",
        "<link",
        "<script",
        "<img",
        "<iframe",
        "<object",
        "@import",
        "url(",
        " src=",
    ):
        assert fetched not in page, fetched


@pytest.mark.parametrize(("preset", "override"), READINGS)
def test_pages_are_self_contained(preset: str, override: str) -> None:
    """A page asks for no other file, nor for the network; every page is whole."""
    pages = pages_of(preset, override)
    assert pages
    for _, _, page in pages:
        assert_self_contained(page)
        assert page.rstrip().endswith("</html>")


@pytest.mark.parametrize(("preset", "override"), READINGS)
def test_page_says_what_is_false_and_where(preset: str, override: str) -> None:
    """Headline, wording, place, scope and the sentence about the broken place are on the page."""
    result = verified(preset, override)
    for decided, run, page in pages_of(preset, override):
        words = text_of(page)
        assert f"{decided.claim.id} is {'violated' if run.is_violation else 'reached'}" in words
        assert decided.claim.wording in words
        assert decided.claim.place in words
        assert "N = 2 UAVs, M = 2 CUs" in words
        assert result.scope.reading.name() in words
        assert f"{result.states:,} states" in words
        last = len(run.events)
        for broken in run.broken_at(last):
            assert what_is_false(SwarmRun.of(run), broken, last) in words


@pytest.mark.parametrize(("preset", "override"), READINGS)
def test_broken_cells_are_marked_and_only_they(preset: str, override: str) -> None:
    """In the table of each round, exactly the cells in which the claim is false are marked."""
    for _, run, page in pages_of(preset, override):
        sections = re.findall(r'<section class="round.*?</section>', page, flags=re.DOTALL)
        assert len(sections) == len(run.states)
        for k, section in enumerate(sections):
            cells = {(w, broken.uav) for broken in run.broken_at(k) for w in broken.cus}
            assert len(re.findall(r'<td class="[^"]*\bbroken\b', section)) == len(cells)
            assert ("is false" in section) == bool(cells)


@pytest.mark.parametrize(("preset", "override"), READINGS)
def test_diagram_is_well_formed_and_draws_each_loss_once(preset: str, override: str) -> None:
    """The diagram is XML, and has as many lost messages as the run."""
    for _, run in shown(verified(preset, override)):
        svg = ElementTree.fromstring(sequence_diagram(SwarmRun.of(run)))
        assert svg.tag == "svg"
        lost = [group for group in svg.iter("g") if group.get("class") == "sd-lost"]
        assert len(lost) == run.lost_messages
        rounds = [text.text for text in svg.iter("text") if text.get("class") == "sd-round"]
        assert rounds == [f"Round {k}" for k in range(len(run.states))]
        broken = run.broken_at(len(run.events))
        assert sum(box.get("class") == "sd-callout" for box in svg.iter("rect")) == len(broken)


def test_diagram_draws_every_reception() -> None:
    """Outside of the metadata row, each message that a receiver decodes is an arrow to it."""
    for _, run in shown(verified("printed", "")):
        svg = ElementTree.fromstring(sequence_diagram(SwarmRun.of(run)))
        tips = sum(1 for _ in svg.iter("polyline")) - (run.trace.loop_start is not None)
        metadata = sum(len(got.lost_uavs) < 2 for events in run.events for got in events.at_cus)
        heard = sum(len(got.inbox.cu_messages) for events in run.events for got in (*events.at_cus, *events.at_uavs))
        own = sum(slot.cu_message is not None for sent in run.sent for slot in sent.air.slots)
        assert tips == metadata + heard - own


def test_lasso_page_marks_the_loop() -> None:
    """Of a recovery that fails, the page marks the loop's rounds and says whether the failure can be avoided."""
    result = verified("printed", "")
    decided, run = next((one, run) for one, run in shown(result) if isinstance(one.claim.question, Recovers))
    page = counterexample_page(decided, run, result)
    words, start = text_of(page), run.trace.loop_start
    assert start is not None
    last = len(run.events)
    assert page.count("↺ in the loop") == last - start
    assert f"{phrases.rounds(start, last - 1)} can repeat for ever" in words
    assert f"behaves as in round {start}" in words
    assert ("The failure is avoidable" in words) is (decided.avoidable is True)
    assert ("The failure is inevitable" in words) is (decided.avoidable is False)


@pytest.mark.parametrize(("preset", "override"), READINGS)
def test_explanations_of_algorithm_2_lead_to_its_flags(preset: str, override: str) -> None:
    """The reasons that the page gives for flags give the flags that the model has."""
    for _, replayed in shown(verified(preset, override)):
        run = SwarmRun.of(replayed)
        for k in range(1, len(run.swarms)):
            for w, cu in enumerate(run.swarms[k].cus):
                update, before = explain_in(run, w, k), run.swarms[k - 1].cus[w]
                flags = [update.flag(i, tracker.deprecated) for i, tracker in enumerate(before.trackers)]
                assert flags == [tracker.deprecated for tracker in cu.trackers]


@pytest.mark.parametrize(("preset", "override"), READINGS)
def test_story_tells_every_change(preset: str, override: str) -> None:
    """Each loss, each new entry, each change of state and each adoption has a sentence in its round."""
    for _, replayed in shown(verified(preset, override)):
        run = SwarmRun.of(replayed)
        for k, events in enumerate(run.events):
            air = " ".join(" ".join((s.text, *s.details)) for s in tell(run, k).air)
            assert ("lost" in air) == (events.lost > 0)
            for i, new in enumerate(events.adopted):
                if new is not None:
                    assert f"{names.uav(i)} received" in air
                    assert f"follows {names.trajectory(new)}" in air
            update = " ".join(s.text for s in tell(run, k + 1).update)
            computed, _ = compute(run.swarms[k], events.decided, run.semantics)
            for cu, after in zip(computed, run.swarms[k + 1].cus, strict=True):
                assert cu.state == after.state or after.state.name in update
                for old, now in zip(cu.trackers, after.trackers, strict=True):
                    for entry in set(now.trajectories) - set(old.trajectories):
                        assert names.trajectory(entry) in update


def test_overview_links_pages_and_tells_all_verdicts() -> None:
    """The overview has every claim with its verdict, the links, what was seen, and the size of the exploration."""
    result = verified("printed", "")
    links = {one.claim.id: f"{one.claim.id}.html" for one, _ in shown(result)}
    page = overview_page(result, links)
    assert_self_contained(page)
    words = text_of(page)
    for one in result.claims:
        assert one.claim.id in words
        assert one.claim.wording in words
        assert (f'href="{one.claim.id}.html"' in page) is (one.trace is not None)
    for seen in result.witnesses:
        assert seen.wording in words
    assert f"{result.transitions:,}" in words
    assert "not applicable" in words
    assert "avoidable" in words


def test_overview_tells_what_was_never_seen() -> None:
    """A situation that no reachable state shows is named; without a fixpoint the page does not say never."""
    result = verified("ignore-loss", "")
    assert any(seen.trace is None for seen in result.witnesses)
    assert "never: no reachable state is such" in overview_page(result, {})
    early = replace(result, stopped="the limit of 10 states")
    page = overview_page(early, {})
    assert "never: no reachable state is such" not in page
    assert "No fixpoint: the exploration stopped early (the limit of 10 states)" in text_of(page)


def test_pages_escape_their_texts() -> None:
    """Text that looks like markup is shown, not interpreted."""
    result = verified("ignore-loss", "")
    decided, run = next((one, run) for one, run in shown(result) if one.verdict is Verdict.VIOLATED)
    nasty = "<script>alert('&')</script>"
    decided = replace(decided, claim=replace(decided.claim, wording=nasty), why=nasty)
    result = replace(result, stopped=nasty, claims=(decided,))
    for page in (counterexample_page(decided, run, result), overview_page(result, {decided.claim.id: '"><u>'})):
        assert nasty not in page
        assert "&lt;script&gt;" in page
        assert '"><u>' not in page


def test_pages_of_more_uavs_than_cus() -> None:
    """A page has a column for each UAV, whatever the numbers."""
    result = verified("ignore-loss", "", uavs=3, cus=2)
    for decided, run in shown(result):
        page = counterexample_page(decided, run, result)
        assert "UAV 2 follows hover" in page
        assert "UAV 3" not in page


def test_names() -> None:
    """Trajectories are named by calculation round and CU; lists and numbers read as English."""
    assert names.trajectory(HOVERING) == "hover"
    assert names.entries([HOVERING, Trajectory(Metadata(4, 1))]) == "{hover, τ(4, CU 1)}"
    assert phrases.listing([]) == ""
    assert phrases.listing(["a"]) == "a"
    assert names.uavs([0, 1, 2]) == "UAV 0, UAV 1 and UAV 2"
    assert phrases.count(1, "round") == "1 round"
    assert phrases.count(0, "round") == "0 rounds"
    assert [phrases.rounds(3, 3), phrases.rounds(3, 4), phrases.rounds(3, 5)] == [
        "round 3",
        "rounds 3 and 4",
        "rounds 3 to 5",
    ]
