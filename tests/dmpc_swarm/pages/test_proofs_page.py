"""The page of the audit: all claims and cells are on it, nothing is fetched, and its pictures show what is decided."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from html import unescape
from html.parser import HTMLParser

import pytest
from tests.dmpc_swarm.proofs.filed import audited

from swarmproof.algebra.grid import Range, Step, Time
from swarmproof.claims.proof import ProofVerdict, Reading
from swarmproof.dmpc_swarm.evidence.book import audit
from swarmproof.dmpc_swarm.pages.proofs.page import audit_page
from swarmproof.dmpc_swarm.pages.proofs.plots import SCENES, draw_ranges, draw_scene, draw_step
from swarmproof.dmpc_swarm.pages.proofs.words import shown
from swarmproof.dmpc_swarm.pair_table import CellAudit, audit_cells
from swarmproof.dmpc_swarm.proofs.registry import select_proof_claims
from swarmproof.dmpc_swarm.proofs.samples import eq_20, planes, repaired_20, rest
from swarmproof.dmpc_swarm.proofs.terms.cells import ROLES, cells
from swarmproof.prove.evidence import Vectors
from swarmproof.prove.script import script
from swarmproof.prove.steps import Covered, decide_step


@cache
def pairs() -> Sequence[CellAudit]:
    """Return the table of pairs: audited once, and only if a test asks."""
    return audit_cells()


@cache
def page_of_all() -> str:
    """Return the page about all claims."""
    return audit_page(audited(), pairs())


class _Reader(HTMLParser):
    """Collects what a page refers to, its ids, its text, and whether its elements are closed."""

    VOID = frozenset({"meta", "br", "link", "img", "input", "hr"})

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.ids: list[str] = []
        self.text: list[str] = []
        self.open: list[str] = []
        self.tags: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.ids += [value or "" for name, value in attrs if name == "id"]
        self.links += [value or "" for name, value in attrs if name in {"href", "src"}]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def read(page: str) -> _Reader:
    """Return what is on a page."""
    reader = _Reader()
    reader.feed(page)
    assert reader.open == []
    return reader


def test_the_page_is_one_file() -> None:
    """Nothing is fetched or run: all links stay on the page and lead somewhere, and there are no scripts."""
    reader = read(page_of_all())
    assert all(link.startswith("#") for link in reader.links)
    assert {link[1:] for link in reader.links} <= set(reader.ids)
    assert len(reader.ids) == len(set(reader.ids))
    assert not reader.tags & {"script", "link", "img", "iframe", "object"}
    assert not re.search(r"https?:|url\(|@import", page_of_all())


def test_every_claim_is_on_the_page() -> None:
    """Each claim has its wording, place, assumptions, finding and every question's evidence."""
    text = "".join(read(page_of_all()).text)
    for each in audited():
        claim = each.claim
        for part in (claim.wording, claim.place, claim.assumptions, claim.finding, *claim.questions):
            assert part in text, (claim.key, part)
        assert all(shown(answer) in text for answer in each.answers)
        assert f'id="{claim.key}"' in page_of_all()


def test_every_counterexample_is_on_the_page_with_its_script() -> None:
    """What is false can be checked by what is on the page."""
    text = "".join(read(page_of_all()).text)
    scripts = [
        script(answer.asked, answer.evidence)
        for each in audited()
        for answer in each.answers
        if answer.verdict is ProofVerdict.FALSE and answer.evidence is not None
    ]
    assert scripts
    assert all(one and one in text for one in scripts)


def test_every_cell_is_on_the_page() -> None:
    """Each of the 21 pairs has a cell in its row and column, with its lemma and verdict in words, and a detail."""
    table = page_of_all()[page_of_all().index('<table class="pairs">') : page_of_all().index("</table>")]
    rows = re.findall(r"<tr>(.*?)</tr>", table, re.DOTALL)[1:]
    assert [re.findall(r"<th>(.*?)</th>", row) for row in rows] == [[role.id] for role in ROLES]
    of = {each.cell: each for each in pairs()}
    seen = 0
    for i, row in zip(ROLES, rows, strict=True):
        for j, cell in zip(ROLES, re.findall(r"<td.*?</td>", row, re.DOTALL), strict=True):
            found = next((each for each in of.values() if (each.cell.i, each.cell.j) == (i, j)), None)
            assert (found is None) == ('class="empty"' in cell)
            if found is not None:
                seen += 1
                assert f'href="#pair-{found.cell.id}"' in cell
                assert found.verdict in cell
                assert f"<b>{found.cell.lemma or 'no lemma'}</b>" in cell
    assert seen == len(list(cells())) == 21


def test_verdicts_are_seen_without_colour() -> None:
    """Each verdict has a sign and a word of its own."""
    tags = set(re.findall(r'<span class="tag \w+">([^<]*)</span>', page_of_all()))
    assert {"✓ proved", "✗ false", "◐ true under (20)", "? not decided"} <= tags
    assert "Every verdict is the one on record" in page_of_all()
    printed = [each for each in audited() if each.claim.reading is Reading.PRINTED]
    refuted = [each for each in printed if each.verdict is ProofVerdict.FALSE]
    assert f"✗ {len(refuted)} of the {len(printed)} claims shown here are false as printed" in page_of_all()
    assert 'class="box good"' not in page_of_all()
    proved = [each for each in printed if each not in refuted]
    assert 'class="box good"' in audit_page(proved, [])


def test_a_verdict_that_is_not_on_record_is_an_alarm() -> None:
    """A changed verdict is named at the top and at its claim."""
    changed = replace(audited()[0], claim=replace(audited()[0].claim, verdict=ProofVerdict.FALSE))
    page = audit_page([changed], [])
    assert f"✗ {changed.claim.key}: not the verdict on record" in page
    assert "on record: false" in page


def test_what_is_not_decided_says_why() -> None:
    """A question whose evidence does not check is shown as not decided, with the reason."""
    asked = audited()[0].answers[0]
    undecided = replace(asked, verdict=ProofVerdict.UNDECIDED, evidence=None, why="there is no proof")
    page = audit_page([replace(audited()[0], verdict=ProofVerdict.UNDECIDED, answers=(undecided,))], [])
    assert "? not decided" in page
    assert "there is no proof" in page


def test_part_of_the_claims_is_a_page_too() -> None:
    """Without the pairs, there is no table, and no picture of what was not asked for."""
    chosen = audit(select_proof_claims(["corollary-1"]))
    page = audit_page(chosen, [])
    assert "corollary-1" in page
    assert '<table class="pairs">' not in page
    assert "<svg" not in page
    read(page)


def test_what_is_written_is_escaped() -> None:
    """Names and words with signs of HTML are shown, not obeyed."""
    evil = "<script>alert('&')</script>"
    claim = replace(audited()[0].claim, wording=evil, finding=evil, questions={evil: audited()[0].answers[0].asked})
    answers = (replace(audited()[0].answers[0], question=evil),)
    page = audit_page([replace(audited()[0], claim=claim, answers=answers)], [])
    assert "<script>" not in page
    assert "".join(read(page).text).count(evil) == 3
    step = Step((Range(evil, Time(0), Time(1)),), Range(evil, Time(0), Time(1)), None)
    drawn = draw_step(step, Covered((evil,), False), 1)
    assert "<script>" not in drawn
    assert evil in unescape(drawn)


def test_pictures_of_counterexamples_are_those_on_file() -> None:
    """Each picture is of a false question of a claim, and says how close the two UAVs come."""
    answers = {(each.claim.key, one.question): one for each in audited() for one in each.answers}
    distances = {}
    for place, scene in SCENES.items():
        evidence = answers[place].evidence
        assert isinstance(evidence, Vectors)
        drawn = draw_scene(scene, evidence.values)
        assert drawn in page_of_all()
        (distances[place[1]],) = re.findall(r">\w new and \w \w+ are (.*?) d̂_min apart<", drawn)
    assert distances["j is in A_ET(k)"] == "3/4"
    assert set(distances.values()) == {"3/4", "0"}


def test_planes_are_where_the_new_positions_are() -> None:
    """In the picture of Lemma 3, the new position is on the plane ½(d̂_min + ‖n‖) away from UAV j."""
    scene = SCENES[("lemma-3/printed", "j is in A_ET(k)")]
    at = {"i_old": Fraction(0), "j_old": Fraction(1, 2), "i_new": Fraction(-1, 4)}
    values = {f"{name}_{axis}": x if axis == "x" else Fraction(0) for name, x in at.items() for axis in "xyz"}
    drawn = draw_scene(scene, {**values, "d": Fraction(1), "l": Fraction(1, 2)})
    (plane,) = re.findall(r'ap-plane-i" x1="([^"]*)" y1="[^"]*" x2="([^"]*)"', drawn)
    (new,) = re.findall(r'ap-dot-i ap-new" cx="([^"]*)"', drawn)
    assert plane == (new, new)
    # an irrational distance is written as a root
    diagonal = {**values, "d": Fraction(1), "i_new_y": Fraction(1, 4)}
    assert "√(5/8) d̂_min" in draw_scene(scene, diagonal)


@pytest.mark.parametrize(
    ("step", "rows"),
    [
        # (20) ends a sample before (13f) does; at rest that does no harm
        (Step((eq_20(2),), planes(2), None), [["given"] * 6, ["covered"] * 6 + ["gap"]]),
        (Step((eq_20(2),), planes(2), rest(2)), [["given"] * 6, ["rest"], ["covered"] * 7]),
        (Step((repaired_20(2),), planes(2), None), [["given"] * 7, ["covered"] * 7]),
    ],
)
def test_pictures_of_steps_show_gaps(step: Step, rows: list[list[str]]) -> None:
    """A row for what is given, one for rest, and one for what is needed, with the samples that are not covered."""
    decided = decide_step(step)
    assert decided is not None
    drawn = draw_step(step, decided, 2)
    kinds = [kind for kind in re.findall(r'class="ap-cell ap-(\w+)"', drawn) if kind != "none"]
    assert kinds == [kind for row in rows for kind in row]
    assert ("not covered: 8" in drawn) == ("gap" in kinds)
    assert drawn.count(">✗<") == kinds.count("gap")


def test_a_gap_of_a_short_horizon_is_drawn_for_it() -> None:
    """Where a step is false for small H only, the picture is of the H of its counterexample."""
    step = Step((Range("given", Time(2), Time(-1, 2)),), Range("needed", Time(2), Time(2)), None)
    decided = decide_step(step)
    assert decided is not None
    assert "(H = 1)" in draw_step(step, decided, 1)
    assert "ap-gap" in draw_step(step, decided, 1)


def test_ranges_are_the_samples_of_their_equations() -> None:
    """Each equation's row is filled at its samples, with gaps where its source has none; H = 3 and T/T_c = 2."""
    drawn = draw_ranges([(eq_20(2), None), (planes(2), eq_20(2))], None, 2)
    assert "(20): 2 to 7; (13f), from (20): 2 to 8, not covered: 8." in drawn
    assert (drawn.count("ap-given"), drawn.count("ap-gap"), drawn.count(">✗<")) == (6 + 6, 1, 1)
    at_rest = draw_ranges([(eq_20(2), None), (planes(2), eq_20(2))], rest(2), 2)
    assert (at_rest.count("ap-given"), at_rest.count("ap-gap"), at_rest.count(">=<")) == (6 + 6, 0, 1)


def test_the_printed_chain_has_gaps_and_the_repaired_one_has_none() -> None:
    """The two pictures of all equations show what the audit of the sample grid decides."""
    printed, repaired = (part for part in page_of_all().split("<svg") if "Samples of each equation" in part)
    assert {int(n) for found in re.findall(r"not covered: ([\d, ]+)", printed) for n in re.findall(r"\d+", found)} == {
        *(8,),  # (13f) from (20)
        *(1,),  # (18) from (20)
        *(7, 8),  # (21) from (19)
        *(9,),  # (20) of round k+1 from (21)
        *(0, 1),  # (23) in round k from (20)
        *(2,),  # (23) in round k+1 from (21)
    }
    assert "not covered" not in repaired
