"""The one grammar of what is lost: models, on which links, in which rounds, and sums of these.

::

    LOSS   = TERM ("+" TERM)*              lost if lost by any term
    TERM   = [WHO ":"] MODEL ["@" WINDOW]  what the model loses on these links, in these rounds
           | WHO ["@" WINDOW]              all that is sent on these links, in these rounds
    MODEL  = none | iid:P | burst:P_ENTER,P_LEAVE | jam:START,ROUNDS | script:FILE
    WHO    = END | END "->" END | END "<->" END
    END    = "*" | "cu*" | "uav*" | "cu" W | "uav" I
    WINDOW = K | K "-" K | K "-"           both ends count; K- has none

A window never changes what is drawn: in its rounds, a term loses what it loses without one. In a sum, the first `iid`
term draws what it draws alone, the next ones independently of it; so do `burst` terms. A link is about what its sender
sends, so that ``uav2`` silences the replies of UAV 2 as well as its metadata, in whatever slot they are.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from swarmproof.errors import BadInput
from swarmproof.faults.combine import Everything, Linked, Links, Sum, Windowed
from swarmproof.faults.forms import COMBINED, FORMS
from swarmproof.faults.losses import FOREVER, Burst, Iid, Jam, Losses, LossModel, Recorded, TermModel
from swarmproof.faults.script import LATER, read_script, shown
from swarmproof.theorem3.numbers import ENTRY, read_number

_WHOLE = re.compile(r"[0-9]{1,9}")
_WINDOW = re.compile(r"([0-9]{1,9})(?:(-)([0-9]{1,9})?)?")
_NEAR_WINDOW = re.compile(r"([0-9]{1,9})\s*(?:,|:|;|-|–|to|\.\.+)\s*([0-9]{1,9})?")
#: How long a text may be, which is far more than anybody writes.
MOST_LENGTH = 10_000

_SCRIPT = re.compile(r"\s*(?:[^:@+]*:\s*)?script:")
#: What comes before a "+" that belongs to a number, and what comes after one that ends the name of a file.
_NUMBER = re.compile(r".*(?:[0-9.][eE]|[:,]\s*)", re.DOTALL)
_TERM = re.compile(r"\s*(?:none|iid:|burst:|jam:|script:|(?:\*|cu|uav)[*0-9]*\s*(?:<?->|[:@+]|$))")


@dataclass(frozen=True)
class Term:
    """A term as it was written, and its model; `model.span` are the rounds in which it can lose something."""

    text: str
    model: TermModel


@dataclass(frozen=True)
class Loss:
    """What was asked for: a loss model that knows its terms.

    Attributes:
        text: as it was written.
    """

    text: str
    terms: tuple[Term, ...]
    model: LossModel

    def losses(self, k: int) -> Losses:
        """Return what is lost in round k ≥ 0."""
        return self.model.losses(k)

    def without_effect(self, rounds: int, lost: int) -> list[str]:
        """Return a sentence for each loss that was asked for and cannot have had any effect; mostly there is none.

        Args:
            rounds: how many were flown, at least one.
            lost: how many messages were lost in them.
        """
        terms = [term for term in self.terms if term.text != "none"]
        if terms and not lost:
            idle = [why for term in terms if (why := _why_idle(term, rounds))]
            whys = f" ({'; '.join(idle)})" if idle else ""
            return [f"Nothing was lost in these {rounds} rounds, although --loss {self.text} was asked for{whys}."]
        return [f"Nothing was lost by {term.text}: {why}." for term in terms if (why := _why_idle(term, rounds))]


def parse(spec: str, uavs: int, cus: int, seed: int, target_change: int = 0) -> Loss:
    """Return the loss model that a text describes.

    Args:
        spec: see the module's grammar; probabilities as decimals or fractions, such as ``iid:0.1`` and
            ``burst:1/20,0.4``; rounds as integers.
        uavs: N.
        cus: M.
        seed: what everything drawn depends on, not negative.
        target_change: the round from which ``jam`` counts its START.

    Raises:
        BadInput: no such loss, or numbers or a file that it cannot work with.
    """
    terms = _terms(spec, uavs, cus, seed, target_change)
    model = terms[0].model if len(terms) == 1 else Sum([term.model for term in terms], uavs, cus)
    return Loss(spec, tuple(terms), model)


def _why_idle(term: Term, rounds: int) -> str:
    """Return why a term cannot lose anything in so many rounds; empty if it can."""
    span = term.model.span
    if span.start >= span.stop:
        return f"{term.text} never loses anything"
    if span.start >= rounds:
        return f"{term.text} begins in round {span.start}, the last round was {rounds - 1}"
    return ""


def _terms(spec: str, uavs: int, cus: int, seed: int, target_change: int) -> list[Term]:
    if seed < 0:
        raise BadInput(f"the seed must not be negative, as {seed} is")
    if len(spec) > MOST_LENGTH:
        raise BadInput(f"the loss {shown(spec)} is too long: at most {MOST_LENGTH} characters, or write script:FILE")
    kinds: Counter[type] = Counter()
    found = []
    for text in _split(spec):
        if not text.strip() and text != spec:
            raise BadInput(f"{shown(spec)} has an empty term: write sums like {COMBINED['TERM+TERM'][0]}")
        body, window = _window(text, is_whole_file=_is_file(spec))
        model = _linked(body, uavs, cus, _Numbers(seed, target_change, kinds))
        if window is not None:
            model = Windowed(model, window, uavs, cus)
        found.append(Term(text.strip(), model))
    return found


def _is_file(spec: str) -> bool:
    """Return whether this is the script of a file that is there, whatever its name looks like."""
    name, _, rest = spec.partition(":")
    return name == "script" and os.path.exists(rest)


def _split(spec: str) -> list[str]:
    """Return the terms of a sum: a "+" may also belong to a number, or to the name of a file."""
    if _is_file(spec):
        return [spec]
    terms = [""]
    for n, part in enumerate(spec.split("+")):
        rest = "+".join(spec.split("+")[n:])
        if n and (_NUMBER.fullmatch(terms[-1]) or (_SCRIPT.match(terms[-1]) and not _TERM.match(rest))):
            terms[-1] += "+" + part
        elif n:
            terms.append(part)
        else:
            terms[0] = part
    return terms


def _window(text: str, is_whole_file: bool) -> tuple[str, range | None]:
    """Return a term without its window, and the window; None without one."""
    body, at, rest = text.rpartition("@")
    if not at or is_whole_file:
        return text, None
    found = _WINDOW.fullmatch(rest.strip())
    if found is None:
        if _SCRIPT.match(text):
            return text, None
        near = _NEAR_WINDOW.fullmatch(rest.strip())
        right = f"{body.strip()}@{near[1]}-{near[2] or ''}" if near else f"{body.strip()}@5-, or {body.strip()}@5-20"
        raise BadInput(f"{shown('@' + rest)} of the loss {shown(text)} is no window of rounds: write {right}")
    first = int(found[1])
    last = first if found[2] is None else FOREVER if found[3] is None else int(found[3])
    if last < first:
        raise BadInput(f"the window of {shown(text)} ends before it begins: write {body.strip()}@{last}-{first}")
    return body, range(first, last + 1)


@dataclass(frozen=True)
class _Numbers:
    """What the models of a sum share: `kinds` counts those that draw."""

    seed: int
    target_change: int
    kinds: Counter[type]

    def nth(self, kind: type) -> int:
        """Return how many of a kind came before."""
        self.kinds[kind] += 1
        return self.kinds[kind] - 1


def _linked(text: str, uavs: int, cus: int, numbers: _Numbers) -> TermModel:
    """Return the model of a term without its window."""
    head, colon, rest = text.partition(":")
    links = Links.read(head, uavs, cus)
    if links is None:
        return _model(text, uavs, cus, numbers)
    if not colon:
        return Linked(Everything(uavs, cus), links)
    try:
        read_number(rest.strip())
    except BadInput:
        return Linked(_model(rest.strip(), uavs, cus, numbers), links)
    raise BadInput(f"{shown(text)} has no model after the link: write {head.strip()}:iid:{rest.strip()}")


def _model(spec: str, uavs: int, cus: int, numbers: _Numbers) -> TermModel:
    name, colon, rest = spec.strip().partition(":")
    if name == "none" and not colon:
        return Recorded((), uavs, cus)
    if name == "iid" and colon:
        (p,) = _values(spec, "iid:P", rest)
        return Iid(uavs, cus, _probability(spec, "P", p), numbers.seed, numbers.nth(Iid))
    if name == "burst" and colon:
        enter, leave = _values(spec, "burst:P_ENTER,P_LEAVE", rest)
        probabilities = _probability(spec, "P_ENTER", enter), _probability(spec, "P_LEAVE", leave)
        return Burst(uavs, cus, *probabilities, numbers.seed, numbers.nth(Burst))
    if name == "jam" and colon:
        start, rounds = _values(spec, "jam:START,ROUNDS", rest)
        return Jam(uavs, cus, numbers.target_change + _whole(spec, "START", start), _whole(spec, "ROUNDS", rounds))
    if name == "script" and rest:
        return Recorded(read_script(Path(spec.partition(":")[2]), uavs, cus), uavs, cus)
    raise BadInput(_unknown(spec))


def _unknown(spec: str) -> str:
    """Return why a text is no loss, and what would be."""
    if re.match(r"(?i)\s*(delay|late|duplicat|dup\b|repeat|reorder|join)", spec):
        return f"{shown(spec)} is not a loss: {LATER}"
    if re.match(r"\s*(cu|uav)[0-9*]*\s*(<?-|:?$)", spec):
        return (
            f"{shown(spec)} is no link: write cu0->uav*, *->cu1 or uav2, in quotes, since a shell has its own use for "
            "> and *"
        )
    if re.match(r"\s*(adversary|exhaustive)", spec):
        return f"{shown(spec)} is a search for losses: it stands alone, and only after `swarmproof fly SCENARIO --loss`"
    choice = ", ".join(FORMS)
    return f"there is no loss model {shown(spec)}: choose {choice}, or a link such as cu0->uav*"


def _values(spec: str, form: str, rest: str) -> list[str]:
    values = [value.strip() for value in rest.split(",")]
    count = form.count(",") + 1
    if len(values) == count and "" not in values:
        return values
    message = f"the loss model {shown(spec)} must have the form {form}, such as {FORMS[form]}"
    first, *window = values[count - 1 :] or [""]
    if window and all(_WHOLE.fullmatch(value) for value in window) and len(window) <= 2 and first:
        given = ",".join(values[:count])
        rounds = "-".join([*window, ""][:2])
        message += f"; rounds come after @: {form.partition(':')[0]}:{given}@{rounds}"
    elif any(re.match(r"(iid|burst|jam|script|cu|uav|\*)", value) for value in values[1:]):
        message += f"; a sum is written with +: {COMBINED['TERM+TERM'][0]}"
    raise BadInput(message)


def _probability(spec: str, name: str, text: str) -> Fraction:
    try:
        value = read_number(text, ENTRY)
    except BadInput as mistake:
        raise BadInput(f"{name} of the loss model {shown(spec)}: {mistake}{_percent(text)}") from None
    if not 0 <= value <= 1:
        raise BadInput(
            f"{name} of the loss model {shown(spec)} is a probability: it must be between 0 and 1, such as 0.1"
        )
    return value


def _percent(text: str) -> str:
    """Return what a percentage is as a decimal, to end a sentence with; empty if `text` is none."""
    try:
        value = read_number(text.removesuffix("%"), ENTRY) / 100
    except BadInput:
        return ""
    return f"; {text} is {value if value.denominator == 1 else float(value)}" if text.endswith("%") else ""


def _whole(spec: str, name: str, text: str) -> int:
    if not _WHOLE.fullmatch(text):
        raise BadInput(
            f"{name} of the loss model {shown(spec)} must be a whole number of rounds, 0 to 999999999, as in "
            f"{FORMS['jam:START,ROUNDS']}"
        )
    return int(text)
