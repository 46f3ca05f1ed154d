"""The page about the audit of the proofs: the table of pairs, claims in both readings, evidence, and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from swarmproof.algebra.grid import Step
from swarmproof.claims.proof import ProofVerdict, Reading
from swarmproof.dmpc_swarm.pages.proofs import words as audit_words
from swarmproof.dmpc_swarm.pages.proofs.plots import SCENES, STYLE, draw_ranges, draw_scene, draw_step
from swarmproof.dmpc_swarm.pair_table import UNDER_20, CellAudit
from swarmproof.dmpc_swarm.proofs import samples
from swarmproof.dmpc_swarm.proofs.terms.cells import ROLES, Role
from swarmproof.dmpc_swarm.semantics import PAPER
from swarmproof.pages import phrases
from swarmproof.pages.page import template
from swarmproof.prove.decide import Answer, Audited
from swarmproof.prove.evidence import Vectors
from swarmproof.prove.steps import Covered, Line

#: T/T_c of the pictures: that of the published experiments.
RATIO = 2
#: How verdicts are written, and their style.
_VERDICTS: dict[str, tuple[str, str]] = {
    ProofVerdict.PROVED: ("✓ proved", "good"),
    UNDER_20: ("◐ true under (20)", "part"),
    ProofVerdict.FALSE: ("✗ false", "bad"),
    ProofVerdict.UNDECIDED: ("? not decided", "dim"),
}
_MEANINGS: dict[str, str] = {
    ProofVerdict.PROVED: "from what the lemma assumes.",
    UNDER_20: "false from that alone, proved if (20) is assumed at the sample, too.",
    ProofVerdict.FALSE: "even with (20).",
    ProofVerdict.UNDECIDED: "the evidence on file does not check.",
}


@dataclass(frozen=True, slots=True)
class Group:
    """Questions of a claim that have the same evidence, with what a reader can check."""

    verdict: ProofVerdict
    kind: str
    text: str
    questions: list[str]


@dataclass(frozen=True, slots=True)
class ReadingView:
    """A claim in one reading, with pictures of its steps by question."""

    audited: Audited
    groups: list[Group]
    strips: list[tuple[str, Markup]]


def audit_page(audited: Sequence[Audited], pairs: Sequence[CellAudit]) -> str:
    """Return the page: one file without resources.

    Args:
        audited: all claims that were decided, in order.
        pairs: all cells of the table, or none.
    """
    by_id: dict[str, list[ReadingView]] = {}
    for each in audited:
        by_id.setdefault(each.claim.id, []).append(ReadingView(each, _groups(each.answers), _strips(each)))
    printed = [each for each in audited if each.claim.reading is Reading.PRINTED]
    stepped = any(isinstance(answer.asked, Step) for each in audited for answer in each.answers)
    return template("audit.html.j2", "swarmproof.dmpc_swarm.pages").render(
        paper=PAPER,
        headline=_headline(audited),
        printed=len(printed),
        refuted=sum(each.verdict is ProofVerdict.FALSE for each in printed),
        alarms=[each.claim.key for each in audited if not each.as_recorded],
        verdicts=_VERDICTS,
        meanings=_MEANINGS,
        roles=ROLES,
        cells=pairs,
        rows=_rows(pairs),
        shown=audit_words.shown,
        claims=list(by_id.items()),
        scenes=_scenes(audited),
        ranges=_ranges() if stepped else [],
        ranges_rest=samples.rest(RATIO, new=True).at(3),
        picture_style=Markup(STYLE),
    )


def _headline(audited: Sequence[Audited]) -> str:
    proved, false = (
        sum(each.verdict is verdict for each in audited) for verdict in (ProofVerdict.PROVED, ProofVerdict.FALSE)
    )
    text = f"The proofs, {phrases.count(len(audited), 'claim')}: {proved} proved, {false} false"
    left = len(audited) - proved - false
    return f"{text}, {left} not decided" if left else text


def _rows(pairs: Sequence[CellAudit]) -> list[tuple[Role, list[CellAudit | None]]]:
    """Return the table of pairs by roles of i and j; below the diagonal there is nothing."""
    of = {(each.cell.i, each.cell.j): each for each in pairs}
    return [(i, [of.get((i, j)) for j in ROLES]) for i in ROLES] if pairs else []


def _groups(answers: Sequence[Answer]) -> list[Group]:
    groups: dict[tuple[ProofVerdict, str], Group] = {}
    for each in answers:
        text = audit_words.shown(each)
        new = Group(each.verdict, audit_words.kind(each.evidence), text, [])
        groups.setdefault((each.verdict, text), new).questions.append(each.question)
    return list(groups.values())


def _strips(audited: Audited) -> list[tuple[str, Markup]]:
    """Return pictures of the steps that are about the published T/T_c."""
    return [
        (each.question, Markup(draw_step(each.asked, each.evidence, RATIO)))
        for each in audited.answers
        if isinstance(each.asked, Step)
        and isinstance(each.evidence, Covered | Line)
        and each.question.startswith(f"T/T_c = {RATIO}")
    ]


def _scenes(audited: Sequence[Audited]) -> list[tuple[str, Markup, str]]:
    answers = {(each.claim.key, answer.question): answer.evidence for each in audited for answer in each.answers}
    return [
        (scene.title, Markup(draw_scene(scene, evidence.values)), key)
        for (key, question), scene in SCENES.items()
        if isinstance(evidence := answers.get((key, question)), Vectors)
    ]


def _ranges() -> list[tuple[str, Markup]]:
    m = RATIO
    rows, new = samples.planes(m)._replace(name="(13f), (22)"), samples.new_ones(m)
    eq_18, eq_19, eq_20, eq_21 = (eq(m) for eq in (samples.eq_18, samples.eq_19, samples.eq_20, samples.eq_21))
    flown = [samples.flown(m, n)._replace(name=f"(23) in round k{'+1' * n}") for n in (0, 1)]
    printed = [
        (eq_20, None),
        (rows, eq_20),
        (new, rows),
        (eq_18, eq_20),
        (eq_19, eq_18),
        (eq_21, eq_19),
        (samples.next_round(eq_20, m), eq_21),
        (flown[0], eq_20),
        (flown[1], eq_21),
    ]
    from_0 = [samples.repaired_20(m)._replace(name="(20)′"), samples.repaired_21(m)._replace(name="(21)′")]
    repaired = [
        (from_0[0], None),
        (rows, from_0[0]),
        (new, rows),
        (from_0[1], from_0[0]),
        (samples.next_round(from_0[0], m), from_0[1]),
        (flown[1], from_0[1]),
    ]
    rest = samples.rest(m, new=True)
    return [
        ("As printed, without terminal rest", Markup(draw_ranges(printed, None, m))),
        ("Repaired: (20)′ and (21)′ with h = 0 … h_c, and terminal rest", Markup(draw_ranges(repaired, rest, m))),
    ]
