"""The switches and presets are the specified ones, and whatever else is asked for is refused in one sentence."""

from __future__ import annotations

from itertools import product

import pytest

from swarmproof.dmpc_swarm.semantics import ABOUT, PRESETS, SWITCHES, Semantics
from swarmproof.errors import BadInput

SPECIFIED_SWITCHES = {
    "deprecation": ("all", "one"),
    "rejoin": ("any-state", "after-reply"),
    "slot_conflict": ("either", "both-lost", "cu-wins"),
    "request_order": ("lowest-index", "round-robin", "any"),
    "event_trigger": ("any", "round-robin"),
    "initial": ("unknown", "known"),
    "loss_handling": ("recover", "ignore"),
}

SPECIFIED_PRESETS = {
    "printed": {},
    "prose": {"deprecation": "one"},
    "guarded": {"deprecation": "one", "rejoin": "after-reply"},
    "ignore-loss": {"loss_handling": "ignore", "initial": "known"},
}


def _all_possible() -> list[dict[str, str]]:
    chosen = [dict(zip(SWITCHES, values, strict=True)) for values in product(*SWITCHES.values())]
    return [values for values in chosen if values["loss_handling"] != "ignore" or values["initial"] == "known"]


def test_switches_and_their_values_are_the_specified_ones() -> None:
    """Every switch has exactly the specified values, in the specified order, and nothing else is a switch."""
    assert SWITCHES == SPECIFIED_SWITCHES
    assert list(SWITCHES) == list(SPECIFIED_SWITCHES)


def test_every_switch_is_explained() -> None:
    """Each switch, and nothing else, has a sentence that says what it is about."""
    assert set(ABOUT) == set(SWITCHES)
    assert all(ABOUT.values())


def test_defaults_are_the_first_values() -> None:
    """Semantics() gives every switch its first value."""
    assert Semantics().as_dict() == {name: values[0] for name, values in SPECIFIED_SWITCHES.items()}


@pytest.mark.parametrize("preset", SPECIFIED_PRESETS)
def test_presets_are_the_specified_ones(preset: str) -> None:
    """A preset sets the specified switches and leaves all others at their defaults."""
    assert Semantics.parse(preset).as_dict() == Semantics().as_dict() | SPECIFIED_PRESETS[preset]


def test_there_are_no_other_presets() -> None:
    """The presets are `printed`, `prose`, `guarded` and `ignore-loss`, and `printed` is what one gets unasked."""
    assert list(PRESETS) == list(SPECIFIED_PRESETS)
    assert Semantics.parse() == Semantics.parse("printed") == Semantics()


@pytest.mark.parametrize("preset", SPECIFIED_PRESETS)
@pytest.mark.parametrize(("switch", "values"), SPECIFIED_SWITCHES.items())
def test_overrides_apply_after_the_preset(preset: str, switch: str, values: tuple[str, ...]) -> None:
    """An override sets its switch whatever the preset says, and touches no other."""
    for value in values:
        wanted = Semantics.parse(preset).as_dict() | {switch: value}
        if wanted["loss_handling"] == "ignore" and wanted["initial"] != "known":
            with pytest.raises(BadInput):
                Semantics.parse(preset, [f"{switch}={value}"])
        else:
            assert Semantics.parse(preset, [f"{switch}={value}"]).as_dict() == wanted


def test_the_last_of_several_overrides_counts() -> None:
    """Of two overrides of one switch, the later one applies; overrides of different switches all apply."""
    parsed = Semantics.parse("guarded", ["rejoin=any-state", "initial=known", "rejoin=after-reply"])
    assert parsed == Semantics(deprecation="one", rejoin="after-reply", initial="known")


def test_values_round_trip() -> None:
    """as_dict and from_values are inverse to each other for every possible semantics."""
    for values in _all_possible():
        semantics = Semantics.from_values(values)
        assert semantics.as_dict() == values
        assert Semantics.from_values(semantics.as_dict()) == semantics


def test_missing_values_are_defaults() -> None:
    """from_values gives a switch that is not mentioned its default."""
    assert Semantics.from_values({}) == Semantics()
    assert Semantics.from_values({"deprecation": "one"}) == Semantics.parse("prose")


@pytest.mark.parametrize(
    ("semantics", "name"),
    [
        (Semantics(), "printed"),
        (Semantics.parse("prose"), "prose"),
        (Semantics.parse("guarded"), "guarded"),
        (Semantics.parse("ignore-loss"), "ignore-loss"),
        (Semantics.parse("guarded", ["initial=known"]), "guarded, initial=known"),
        (Semantics.parse("printed", ["deprecation=one", "rejoin=after-reply"]), "guarded"),
        (
            Semantics.parse("printed", ["slot_conflict=cu-wins", "request_order=any"]),
            "printed, slot_conflict=cu-wins, request_order=any",
        ),
        (Semantics.parse("ignore-loss", ["event_trigger=round-robin"]), "ignore-loss, event_trigger=round-robin"),
    ],
)
def test_name_is_the_nearest_preset_and_what_differs(semantics: Semantics, name: str) -> None:
    """A semantics is named after the preset that differs in the fewest switches, followed by these."""
    assert semantics.name() == name


def test_names_can_be_parsed_back() -> None:
    """The name of every possible semantics, read as a preset and its overrides, is that semantics again."""
    for values in _all_possible():
        semantics = Semantics.from_values(values)
        preset, *overrides = semantics.name().split(", ")
        assert Semantics.parse(preset, overrides) == semantics


@pytest.mark.parametrize(
    ("preset", "overrides", "mentions"),
    [
        ("guardd", [], ["guardd", "printed, prose, guarded or ignore-loss"]),
        ("", [], ["printed, prose, guarded or ignore-loss"]),
        ("printed", ["rejoin"], ["rejoin", "SWITCH=VALUE"]),
        ("printed", [""], ["SWITCH=VALUE"]),
        ("printed", ["rejoice=after-reply"], ["rejoice", "rejoin", "loss_handling"]),
        ("printed", ["=after-reply"], ["rejoin"]),
        ("printed", ["rejoin=later"], ["rejoin", "later", "any-state or after-reply"]),
        ("printed", ["rejoin="], ["rejoin", "any-state or after-reply"]),
        ("printed", ["rejoin=after-reply=x"], ["after-reply=x", "any-state or after-reply"]),
        ("printed", ["slot_conflict= either"], ["either, both-lost or cu-wins"]),
        ("printed", ["loss_handling=ignore"], ["loss_handling=ignore", "initial=known"]),
        ("ignore-loss", ["initial=unknown"], ["loss_handling=ignore", "initial=known"]),
    ],
)
def test_bad_input_is_refused_in_one_helpful_sentence(preset: str, overrides: list[str], mentions: list[str]) -> None:
    """What cannot be is a BadInput of one sentence that says what is wrong and what would be right."""
    with pytest.raises(BadInput) as raised:
        Semantics.parse(preset, overrides)
    message = str(raised.value)
    assert "\n" not in message
    assert ". " not in message
    for mention in mentions:
        assert mention in message


@pytest.mark.parametrize("values", [{"rejoice": "after-reply"}, {"rejoin": "later"}, {"loss_handling": "ignore"}])
def test_bad_values_are_refused(values: dict[str, str]) -> None:
    """from_values refuses unknown switches, unknown values, and ignoring loss without initial knowledge."""
    with pytest.raises(BadInput):
        Semantics.from_values(values)


def test_ignoring_loss_with_initial_knowledge_is_fine() -> None:
    """loss_handling=ignore is accepted as soon as initial=known, in whichever order they are set."""
    either_order = (["loss_handling=ignore", "initial=known"], ["initial=known", "loss_handling=ignore"])
    assert {Semantics.parse("printed", overrides) for overrides in either_order} == {Semantics.parse("ignore-loss")}


def test_semantics_cannot_be_changed() -> None:
    """A semantics is a value: it can be compared and hashed, and its switches cannot be set."""
    semantics = Semantics.parse("guarded")
    assert len({semantics, Semantics.parse("guarded")}) == 1
    with pytest.raises(AttributeError):
        semantics.rejoin = "any-state"  # type: ignore[misc]
