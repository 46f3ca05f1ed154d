"""All kinds of pages: a reader finds the way back and to each part, on a phone and on paper."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest

from swarmproof.campaign.matrix import RowResult, load_matrix, select_rows
from swarmproof.cli import main
from swarmproof.dmpc_swarm.experiments.experiments import EXPERIMENTS
from swarmproof.dmpc_swarm.pages.experiments.page import put_reproduction
from swarmproof.dmpc_swarm.system import SYSTEM
from swarmproof.explore.decide import verify
from swarmproof.explore.search import Limits
from swarmproof.output import ReportFolder
from swarmproof.pages.matrix import put_matrix

#: Every kind of page, and the page above it.
PAGES = {
    "verify/index.html": None,
    "verify/lemma-1.html": "index.html",
    "matrix/index.html": None,
    "matrix/2x1-ignore-loss/index.html": "../index.html",
    "matrix/2x1-ignore-loss/lemma-1.html": "index.html",
    "fly/index.html": None,
    "patterns/index.html": None,
    "audit/index.html": None,
    "reproduce/index.html": None,
}
#: What a wide thing may stand in, such that the page itself is never wider than the screen.
BOXES = {"scroll", "diagram", "pictures"}


class Page(HTMLParser):
    """A page: its elements with the classes around them, its identifiers and links."""

    VOID = frozenset({"meta", "br", "img", "link", "hr", "input", "path", "use", "col"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[tuple[str, set[str]]] = []
        self.found: list[tuple[str, dict[str, str], set[str]]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note an element."""
        given = {name: value or "" for name, value in attrs}
        classes = set(given.get("class", "").split())
        self.found.append((tag, given, set().union(*(around for _, around in self.open), classes)))
        if tag not in self.VOID:
            self.open.append((tag, classes))

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note an element without content."""
        self.found.append((tag, {name: value or "" for name, value in attrs}, set()))

    def handle_endtag(self, tag: str) -> None:
        """Leave an element."""
        while self.open and self.open.pop()[0] != tag:
            pass

    def all(self, tag: str) -> list[dict[str, str]]:
        """Return the attributes of all elements of a kind."""
        return [given for name, given, _ in self.found if name == tag]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a page of every kind."""
    folder = tmp_path_factory.mktemp("pages")
    main(["verify", "--semantics", "ignore-loss", "--report", str(folder / "verify")])
    rows = select_rows(load_matrix(SYSTEM), {"uavs": 2, "cus": 1}, None)
    with ReportFolder(folder / "matrix") as report:
        put_matrix(report, [RowResult(row, verify(row.scope, limits=Limits())) for row in rows])
        report.publish()
    jam = ["--loss", "jam:3,10", "--semantics", "ignore-loss"]
    main(["fly", "crossing", "--rounds", "12", *jam, "--report", str(folder / "fly")])
    main(["fly", "crossing", "--loss", "exhaustive:1", "--report", str(folder / "patterns")])
    main(["audit", "--claim", "lemma-3", "--claim", "next-round", "--report", str(folder / "audit")])
    with ReportFolder(folder / "reproduce") as report:
        put_reproduction(report, EXPERIMENTS["loss"](True), {}, quick=True)
        report.publish()
    return folder


@pytest.fixture(params=PAGES, ids=lambda name: name.removesuffix(".html").replace("/", "-"))
def page(request: pytest.FixtureRequest, folder: Path) -> tuple[Path, Page, str | None]:
    """Return each page: its path, what is in it, and the page above it."""
    path = folder / request.param
    return path, Page(path.read_text(encoding="utf-8")), PAGES[request.param]


def test_a_page_has_one_main_part_and_fits_a_screen(page: tuple[Path, Page, str | None]) -> None:
    """There is one `main` and one heading of the first order, and the screen's width is that of the page."""
    _, content, _ = page
    assert [len(content.all(tag)) for tag in ("main", "h1")] == [1, 1]
    assert any(
        given.get("name") == "viewport" and "width=device-width" in given["content"] for given in content.all("meta")
    )


def test_links_lead_somewhere(page: tuple[Path, Page, str | None]) -> None:
    """Each link leads to a part of a page, or to a file that is there; no identifier is there twice."""
    path, content, above = page
    ids = [given["id"] for _, given, _ in content.found if "id" in given]
    assert len(ids) == len(set(ids))
    targets = [given["href"] for given in content.all("a")] + [given["src"] for given in content.all("img")]
    for target in targets:
        file, _, part = target.partition("#")
        if file:
            assert (path.parent / unquote(file)).is_file(), target
        else:
            assert part in ids, target
    assert above is None or above in targets
    assert len([target for target in targets if target.startswith("#")]) > 0 or path.parts[-2] not in ("fly", "audit")


def test_only_boxes_scroll(page: tuple[Path, Page, str | None]) -> None:
    """A table or drawing that is wider than a phone's screen scrolls within a box of its own."""
    _, content, _ = page
    wide = [(tag, given, around) for tag, given, around in content.found if tag in ("table", "svg", "pre")]
    assert wide
    for tag, given, around in wide:
        assert tag == "pre" or around & (BOXES | {"facts"}), (tag, given)


def test_rounds_of_a_counterexample_are_linked(folder: Path) -> None:
    """Each round can be gone to, and the one in which the claim is false is marked in the list."""
    content = Page((folder / "verify" / "lemma-1.html").read_text(encoding="utf-8"))
    rounds = [given["id"] for given in content.all("section") if given.get("id", "").startswith("round-")]
    assert len(rounds) >= 2
    assert [given["href"] for given in content.all("a") if "#round-" in given["href"]] == [f"#{one}" for one in rounds]


def test_a_flight_says_first_whether_uavs_collided(folder: Path) -> None:
    """That is what the reader of a flight asks first."""
    text = (folder / "fly" / "index.html").read_text(encoding="utf-8")
    (first, *_) = re.findall(r'<strong class="what">([^<]*)', text)
    assert re.fullmatch(r"✓ No two UAVs collided: .* at least 0\.\d{6} m apart .*; d_min is 0\.12 m\.", first)
    (first, *_) = re.findall(r'<strong class="what">([^<]*)', (folder / "patterns" / "index.html").read_text())
    assert first.startswith("✓ No two UAVs collided: ")
