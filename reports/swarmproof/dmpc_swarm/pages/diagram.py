"""A message-sequence diagram of a run, as inline SVG: lifelines of UAVs and CUs, time downwards, one band per round."""

from __future__ import annotations

from html import escape

from swarmproof.dmpc_swarm.pages import names
from swarmproof.dmpc_swarm.pages.swarm_run import SwarmRun
from swarmproof.dmpc_swarm.protocol.event_trigger import select_uav
from swarmproof.dmpc_swarm.protocol.messages import EmptyMessage, TrajectoryMessage, TrajectoryRequestMessage
from swarmproof.dmpc_swarm.protocol.network import Reception, Slot
from swarmproof.pages import phrases

#: Widths in pixels: of the labels on the left, of one lifeline's column, between UAVs and CUs.
LABELS, COLUMN, GAP = 150, 206, 20
CHIP = 194
#: How far a diagram shrinks to fit a page before it has to be scrolled.
SMALLEST = 0.72

STYLE = """
.sd { font: 12px system-ui, -apple-system, "Segoe UI", "Liberation Sans", "DejaVu Sans", sans-serif; }
.sd text { fill: #1b1f24; } .sd .sd-small { font-size: 10.5px; fill: #444c56; }
.sd .sd-round { font-size: 15px; font-weight: 700; } .sd .sd-b { font-weight: 700; }
.sd-life { stroke: #8c959f; stroke-width: 1.2; } .sd-band { fill: #ffffff; } .sd-band-odd { fill: #f4f6f8; }
.sd-chip { fill: #fff; stroke: #57606a; stroke-width: 1; } .sd-new { stroke: #0a3069; stroke-width: 2.2; }
.sd-RUN_DMPC { fill: #d7f5df; stroke: #1a7f37; } .sd-WAIT { fill: #fff3c4; stroke: #8a6500; }
.sd-REQUEST_TRAJECTORY { fill: #dcebff; stroke: #0a57c2; } .sd-WAIT_FOR_UPDATE { fill: #ecdfff; stroke: #6e3bbd; }
.sd-pill { fill: #fff; stroke: #0a3069; } .sd-pill-reply { fill: #f3ecff; stroke: #6e3bbd; }
.sd-arrow { stroke: #0a3069; stroke-width: 1.5; fill: none; }
.sd-reply { stroke: #6e3bbd; stroke-width: 1.5; fill: none; }
.sd-faint { stroke: #afb8c1; stroke-width: 1; fill: none; }
.sd-lost line { stroke: #c4001a; stroke-width: 1.8; } .sd-lost .sd-dash { stroke-dasharray: 6 4; }
.sd .sd-lost text { fill: #c4001a; font-weight: 700; font-size: 11px; }
.sd-conflict { fill: #fff1e0; stroke: #bc4c00; stroke-width: 1.5; stroke-dasharray: 3 2; }
.sd .sd-conflict-text { fill: #953800; font-weight: 700; }
.sd-broken { fill: none; stroke: #c4001a; stroke-width: 3.5; } .sd-callout { fill: #c4001a; }
.sd .sd-callout-text { fill: #fff; font-weight: 700; }
.sd-loop { fill: none; stroke: #0a3069; stroke-width: 3; } .sd .sd-loop-text { fill: #0a3069; font-weight: 700; }
.sd-reached { fill: none; stroke: #1a7f37; stroke-width: 3.5; }
.sd .sd-reached-text { fill: #116329; font-weight: 700; }
"""


class _Drawing:
    """The SVG elements drawn so far, and where the lifelines are."""

    def __init__(self, uavs: int, cus: int) -> None:
        self.uavs, self.cus = uavs, cus
        self.band = "sd-band"
        self.bands: list[str] = []
        self.back: list[str] = []
        self.front: list[str] = []
        self.width = LABELS + COLUMN * (uavs + cus) + GAP + 10

    def uav(self, i: int) -> float:
        """Return where UAV i's lifeline is."""
        return LABELS + COLUMN * (i + 0.5)

    def cu(self, w: int) -> float:
        """Return where CU w's lifeline is."""
        return LABELS + GAP + COLUMN * (self.uavs + w + 0.5)

    def text(self, x: float, y: float, words: str, style: str = "", anchor: str = "middle") -> None:
        """Write `words` at (x, y)."""
        self.front.append(
            f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" class="{style}">{escape(words, quote=False)}</text>'
        )

    def box(self, x: float, y: float, width: float, height: float, style: str, round_: float = 3) -> None:
        """Draw a box with its upper left corner at (x, y)."""
        self.front.append(_rect(x, y, width, height, style, round_))

    def chip(self, x: float, y: float, words: str, style: str, round_: float = 3) -> None:
        """Draw words in a box of a lifeline's width, centred at x, from y down."""
        self.box(x - CHIP / 2, y, CHIP, 22, style, round_)
        self.text(x, y + 15.5, words)

    def arrow(self, x1: float, y1: float, x2: float, y2: float, style: str) -> None:
        """Draw an arrow that arrives."""
        self.front.append(f'<line x1="{x1:g}" y1="{y1:g}" x2="{x2:g}" y2="{y2:g}" class="{style}"/>')
        back = -7 if x2 > x1 else 7
        slope = (y2 - y1) / (x2 - x1) if x2 != x1 else 0.0
        tips = [f"{x2 + back:g},{y2 + back * slope + side:g}" for side in (-3.5, 3.5)]
        self.front.append(f'<polyline points="{tips[0]} {x2:g},{y2:g} {tips[1]}" class="{style}"/>')

    def lost(self, x1: float, y1: float, x2: float, y2: float, title: str) -> None:
        """Draw an arrow that ends in an x before its receiver."""
        toward = 1 if x2 > x1 else -1
        share = 1 - 26 / abs(x2 - x1)
        x, y = x1 + (x2 - x1) * share, y1 + (y2 - y1) * share
        cross = "".join(f'<line x1="{x - 5:g}" y1="{y - 5 * d:g}" x2="{x + 5:g}" y2="{y + 5 * d:g}"/>' for d in (1, -1))
        self.front.append(
            f'<g class="sd-lost"><title>{escape(title, quote=False)}</title>'
            f'<line class="sd-dash" x1="{x1:g}" y1="{y1:g}" x2="{x - 4 * toward:g}" y2="{y:g}"/>{cross}'
            f'<text x="{x:g}" y="{y + 15:g}" text-anchor="middle">lost</text></g>'
        )


def _rect(x: float, y: float, width: float, height: float, style: str, round_: float = 0) -> str:
    return f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="{round_:g}" class="{style}"/>'


def sequence_diagram(replayed: SwarmRun) -> str:
    """Return the message-sequence diagram of a run as SVG that needs nothing around it."""
    drawing = _Drawing(replayed.uavs, replayed.cus)
    y = 6.0
    starts = []
    for k in range(len(replayed.swarms)):
        starts.append(y)
        drawing.band = "sd-band-odd" if k % 2 else "sd-band"
        bottom = _round(drawing, replayed, k, y + 6)
        drawing.bands.append(_rect(0, y, drawing.width, bottom - y, drawing.band))
        y = bottom
    for x in [drawing.uav(i) for i in range(replayed.uavs)] + [drawing.cu(w) for w in range(replayed.cus)]:
        drawing.back.append(f'<line x1="{x:g}" y1="6" x2="{x:g}" y2="{y:g}" class="sd-life"/>')
    if replayed.loop_start is not None:
        _loop(drawing, starts[replayed.loop_start], starts[-1], replayed.loop_start, len(replayed.events) - 1)
    length = phrases.count(len(replayed.events), "round")
    label = f"Message-sequence diagram of {length}, {phrases.losses(replayed.lost_messages)}"
    size = f'viewBox="0 0 {drawing.width:g} {y + 6:g}" width="{drawing.width:g}" height="{y + 6:g}"'
    size += f' style="max-width: 100%; min-width: {SMALLEST * drawing.width:.0f}px; height: auto"'
    body = "\n".join([*drawing.bands, *drawing.back, *drawing.front])
    return f'<svg class="sd" role="img" aria-label="{escape(label)}" {size}>\n<style>{STYLE}</style>\n{body}\n</svg>'


def _round(drawing: _Drawing, replayed: SwarmRun, k: int, y: float) -> float:
    """Draw round k from y down; return where it ends."""
    last = k == len(replayed.events)
    drawing.text(12, y + 16, f"Round {k}", "sd-round", "start")
    y = _computation(drawing, replayed, k, y)
    if last:
        return _ending(drawing, replayed, k, y) + 6
    y = _metadata(drawing, replayed, k, y)
    for slot, sent in enumerate(replayed.airs[k].slots):
        y = _slot(drawing, replayed, k, slot, sent, y)
    return _adoption(drawing, replayed, k, y) + 6


def _computation(drawing: _Drawing, replayed: SwarmRun, k: int, y: float) -> float:
    swarm, before = replayed.swarms[k], replayed.swarms[k - 1] if k else None
    drawing.text(12, y + 31, "computation phase", "sd-small", "start")
    for uav in swarm.uavs:
        changed = before is not None and before.uavs[uav.i].followed != uav.followed
        words = f"{names.uav(uav.i)} {'now ' if changed else ''}follows {names.trajectory(uav.followed)}"
        drawing.chip(drawing.uav(uav.i), y, words, "sd-chip sd-new" if changed else "sd-chip", 10)
    extra = 0.0
    for cu in swarm.cus:
        x = drawing.cu(cu.w)
        drawing.chip(x, y, f"{names.cu(cu.w)}: {cu.state.name}", f"sd-chip sd-{cu.state.name}")
        deprecated = sum(tracker.deprecated for tracker in cu.trackers)
        flags = f"{deprecated} of {len(cu.trackers)} trackers deprecated" if deprecated else "no tracker deprecated"
        _beside(drawing, x, y + 34, flags)
        if cu.a_et is not None:
            selected = select_uav(cu.a_et, k, cu.w, len(swarm.cus))
            ranked = "⟨" + ", ".join(str(i) for i in cu.a_et) + "⟩"
            _beside(
                drawing, x, y + 48, f"A_ET = {ranked}, selects {'nobody' if selected is None else names.uav(selected)}"
            )
            extra = 14.0
    for broken in replayed.broken[k]:
        for w in broken.cus:
            drawing.box(drawing.cu(w) - CHIP / 2 - 4, y - 4, CHIP + 8, 44 + extra, "sd-broken", 6)
        if broken.uav is not None:
            drawing.box(drawing.uav(broken.uav) - CHIP / 2 - 4, y - 4, CHIP + 8, 30, "sd-broken", 12)
    y += 44 + extra
    for broken in replayed.broken[k]:
        y = _callout(drawing, replayed, k, broken.cus, broken.uav, y)
    return y


def _beside(drawing: _Drawing, x: float, y: float, words: str) -> None:
    """Write a small line on a lifeline, readable over it."""
    width = 6.2 * len(words)
    drawing.box(x - width / 2, y - 10, width, 13, drawing.band, 0)
    drawing.text(x, y, words, "sd-small")


def _callout(drawing: _Drawing, replayed: SwarmRun, k: int, cus: tuple[int, ...], uav: int | None, y: float) -> float:
    """Say in a red bar what is false; return where it ends."""
    swarm = replayed.swarms[k]
    if uav is None:
        words = f"✗ {replayed.shows} is false: {names.cus(cus)} compute different sets A_ET({k})"
    elif replayed.shows == "one-planner-per-uav":
        words = f"✗ {replayed.shows} is false: {names.cus(cus)} both plan {names.uav(uav)}"
    else:
        held = [f"{names.cu(w)} holds {names.entries(swarm.cus[w].trackers[uav].trajectories)}" for w in cus]
        follows = f"{names.uav(uav)} follows {names.trajectory(swarm.uavs[uav].followed)}"
        words = f"✗ {replayed.shows} is false about {names.uav(uav)}: {phrases.listing(held)}; {follows}"
    drawing.box(LABELS, y + 2, drawing.width - LABELS - 8, 22, "sd-callout", 4)
    drawing.text((LABELS + drawing.width - 8) / 2, y + 17.5, words, "sd-callout-text")
    return y + 28


def _ending(drawing: _Drawing, replayed: SwarmRun, k: int, y: float) -> float:
    """Draw what the last computation phase shows beyond broken places; return where it ends."""
    middle = (LABELS + drawing.width - 8) / 2
    if replayed.loop_start is not None:
        words = f"↺ the swarm behaves as in round {replayed.loop_start}: the loop closes"
        drawing.box(LABELS, y + 2, drawing.width - LABELS - 8, 22, "sd-chip", 4)
        drawing.text(middle, y + 17.5, words, "sd-loop-text")
        return y + 28
    if not replayed.is_violation and not replayed.broken[k]:
        drawing.box(LABELS, y - 48, drawing.width - LABELS - 4, 46, "sd-reached", 6)
        drawing.text(middle, y + 14, f"✓ {replayed.shows}: reached", "sd-reached-text")
        return y + 20
    return y


def _metadata(drawing: _Drawing, replayed: SwarmRun, k: int, y: float) -> float:
    """Draw the UAVs' metadata messages: one line for those received, and each lost one; return where they end."""
    events = replayed.events[k]
    drawing.text(12, y + 12, "metadata of all UAVs", "sd-small", "start")
    reached = [w for w, got in enumerate(events.at_cus) if len(got.lost_uavs) < len(events.at_uavs)]
    for i in range(drawing.uavs):
        drawing.front.append(f'<circle cx="{drawing.uav(i):g}" cy="{y + 8:g}" r="3" fill="#8c959f"/>')
    for w in reached:
        start = drawing.uav(0) if w == reached[0] else drawing.cu(reached[0])
        drawing.arrow(start, y + 8, drawing.cu(w), y + 8, "sd-faint")
    y += 18
    for w, got in enumerate(events.at_cus):
        for i in got.lost_uavs:
            drawing.text(12, y + 14, f"metadata of {names.uav(i)}", "sd-small", "start")
            drawing.lost(
                drawing.uav(i), y + 8, drawing.cu(w), y + 8, f"{names.uav(i)}'s metadata to {names.cu(w)}: lost"
            )
            y += 28
    return y


def _slot(drawing: _Drawing, replayed: SwarmRun, k: int, slot: int, sent: Slot, y: float) -> float:
    """Draw what happens in the slot of one CU; return where it ends."""
    label = f"slot {slot}"
    if sent.cu_message is None and sent.reply is None:
        drawing.text(12, y + 14, f"{label} (empty)", "sd-small", "start")
        _beside(drawing, drawing.cu(slot), y + 14, "silent, and nobody answers")
        return y + 24
    if not sent.conflict:
        drawing.text(12, y + 15, label + (f" of {names.cu(slot)}" if sent.reply is None else ""), "sd-small", "start")
        if sent.reply is not None:
            drawing.text(12, y + 28, f"donated to {names.uav(sent.reply.uav)}", "sd-small", "start")
            _beside(drawing, drawing.cu(slot), y + 13, "silent")
        return _fan(drawing, replayed, k, slot, sent, y + 2, of_reply=sent.reply is not None)
    top = y + 3
    drawing.text(12, y + 18, f"{label}: CONFLICT", "sd-conflict-text", "start")
    drawing.text(12, y + 32, "two transmitters", "sd-small", "start")
    drawing.text(12, y + 46, "an arrow: decoded", "sd-small", "start")
    y = _fan(drawing, replayed, k, slot, sent, y + 8, of_reply=False)
    y = _fan(drawing, replayed, k, slot, sent, y, of_reply=True)
    drawing.back.append(_rect(4, top, drawing.width - 12, y - top + 1, "sd-conflict", 4))
    return y + 5


def _fan(drawing: _Drawing, replayed: SwarmRun, k: int, slot: int, sent: Slot, y: float, *, of_reply: bool) -> float:
    """Draw one message with an arrow to each receiver that gets it, and the losses; return where it ends."""
    if of_reply:
        assert sent.reply is not None
        x, words, style, addressee = drawing.uav(sent.reply.uav), names.reply(sent.reply), "sd-reply", None
    else:
        assert sent.cu_message is not None
        x, words, style = drawing.cu(slot), names.message(sent.cu_message), "sd-arrow"
        addressed = isinstance(sent.cu_message, TrajectoryMessage | TrajectoryRequestMessage)
        addressee = sent.cu_message.uav if addressed and not isinstance(sent.cu_message, EmptyMessage) else None
    events = replayed.events[k]
    receivers: list[tuple[float, Reception, bool, str]] = [
        *((drawing.uav(i), got, i == addressee, names.uav(i)) for i, got in enumerate(events.at_uavs)),
        *((drawing.cu(w), got, True, names.cu(w)) for w, got in enumerate(events.at_cus)),
    ]
    for at, got, matters, name in receivers:
        if at == x:
            continue
        if slot in got.lost_slots and not (of_reply and sent.conflict):
            drawing.lost(x, y + 18, at, y + 40, f"{names.on_slot(slot, sent)} to {name}: lost")
        elif slot in got.inbox.cu_messages and not (at == drawing.cu(slot) and sent.conflict):
            decoded_reply = sent.cu_message is None or slot in got.decoded_replies
            if decoded_reply == of_reply:
                drawing.arrow(x, y + 18, at, y + 40, style if matters else "sd-faint")
    width = 6.6 * len(words) + 18
    drawing.box(x - width / 2, y, width, 19, "sd-pill-reply" if of_reply else "sd-pill", 9)
    drawing.text(x, y + 13.5, words)
    lost_here = any(slot in got.lost_slots for _, got, _, _ in receivers)
    return y + (56 if lost_here else 46)


def _adoption(drawing: _Drawing, replayed: SwarmRun, k: int, y: float) -> float:
    """Mark the UAVs that adopt a new trajectory; return where the marks end."""
    adopted = [(i, new) for i, new in enumerate(replayed.events[k].adopted) if new is not None]
    if not adopted:
        return y
    drawing.text(12, y + 14, "adoption (eq. 10)", "sd-small", "start")
    for i, new in adopted:
        words = f"◆ adopts {names.trajectory(new)}"
        x, width = drawing.uav(i), 7 * len(words) + 16
        drawing.box(x - width / 2, y + 1, width, 19, "sd-chip sd-new", 9)
        drawing.text(x, y + 14.5, words, "sd-b")
    return y + 24


def _loop(drawing: _Drawing, top: float, bottom: float, start: int, end: int) -> None:
    """Bracket the rounds that go round for ever."""
    drawing.front.append(
        f'<polyline points="9,{top + 3:g} 3,{top + 3:g} 3,{bottom - 3:g} 9,{bottom - 3:g}" class="sd-loop"/>'
    )
    which = phrases.rounds(start, end)
    middle = (top + bottom) / 2
    drawing.front.append(
        f'<text transform="translate({LABELS - 8:g} {middle:g}) rotate(-90)" text-anchor="middle" class="sd-loop-text">'
        f"↺ loop: {which}, for ever</text>"
    )
