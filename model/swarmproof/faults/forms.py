"""How losses are written: the forms of :mod:`swarmproof.faults.grammar`, with examples."""

from __future__ import annotations

#: The models, with an example each.
FORMS = {
    "none": "none",
    "iid:P": "iid:0.1",
    "burst:P_ENTER,P_LEAVE": "burst:0.05,0.4",
    "jam:START,ROUNDS": "jam:5,10",
    "script:FILE": "script:losses.json",
}
#: What can be made of them, with an example each, and what that means.
COMBINED = {
    "TERM@FIRST-LAST": ("iid:0.2@300-115000", "only in these rounds, both included"),
    "TERM@FIRST-": ("burst:0.05,0.4@5-", "from this round on"),
    "WHO": ("uav1@0-9", "all that UAV 1 sends, to whomever: it is silent"),
    "WHO->WHO": ("cu0->uav*", "all on these links: uav* are all UAVs, * is everybody"),
    "WHO<->WHO": ("uav1<->*@0-9", "the same both ways: UAV 1 is off"),
    "WHO:MODEL": ("*->cu1:iid:0.3", "what the model loses on these links"),
    "TERM+TERM": ("iid:0.1+jam:3,10", "lost if lost by any term"),
}
