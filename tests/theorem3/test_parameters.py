"""Parameters are read exactly as they are written, and what cannot be is refused in one sentence."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarmproof.errors import BadInput
from swarmproof.margin.solve import changed
from swarmproof.theorem3.numbers import exact_text, read_number
from swarmproof.theorem3.parameters import EXTENSIONS, NAMES, PUBLISHED_SCALING, Parameters, Reading
from swarmproof.theorem3.values import Box, Matrix, Vector, diagonal

SPECIFIED_NAMES = (
    *("T_c", "T_s", "T_b", "d_hat_min", "v_max", "a_max", "j_max"),
    *("theta_inverse", "order", "workspace", "d_min", "tracking_error"),
)
COUPLED = "2,1,0,1,2,0,0,0,0.5"


#: The same examples every time, and no clock.
SETTINGS = settings(max_examples=80, deadline=None, derandomize=True, database=None)


def _vector(x: str, y: str, z: str) -> Vector:
    return (Fraction(x), Fraction(y), Fraction(z))


def _range(low: str, high: str) -> tuple[Fraction, Fraction]:
    return (Fraction(low), Fraction(high))


def _toml(folder: Path, text: str) -> Path:
    path = folder / "parameters.toml"
    path.write_text(text, encoding="utf-8")
    return path


def _mistake(folder: Path, text: str) -> str:
    """Return what is said of a parameter file with this text."""
    with pytest.raises(BadInput) as refusal:
        Parameters.from_toml(_toml(folder, text))
    return str(refusal.value)


numbers = st.one_of(
    st.decimals(min_value="0.001", max_value=1000, places=4).map(Fraction),
    st.fractions(min_value=Fraction(1, 1000), max_value=1000, max_denominator=9973),
)
bounds = st.one_of(st.just(Fraction(0)), numbers)
per_axis = st.one_of(bounds.map(lambda value: (value, value, value)), st.tuples(bounds, bounds, bounds))


@st.composite
def scalings(draw: st.DrawFn) -> Matrix:
    """Draw a symmetric positive definite matrix, often diagonal or isotropic."""
    a, b, c = draw(st.one_of(numbers.map(lambda value: (value, value, value)), st.tuples(numbers, numbers, numbers)))
    x, y, z = draw(st.tuples(*[st.sampled_from([Fraction(0), Fraction(1, 3), Fraction(-2, 5)])] * 3))
    # each diagonal entry outweighs the rest of its row
    return ((a + 2, x, y), (x, b + 2, z), (y, z, c + 2)) if x or y or z else diagonal((a, b, c))


@st.composite
def boxes(draw: st.DrawFn) -> Box:
    """Draw a workspace."""
    x, y, z = (sorted(draw(st.tuples(bounds, bounds))) for _ in range(3))
    return ((-x[0], x[1]), (y[0], y[1]), (-z[1], -z[0]))


parameters = st.builds(
    Parameters,
    T_c=numbers,
    T_s=st.one_of(st.just(Fraction(1, 5)), numbers),
    T_b=st.one_of(st.just(Fraction(1, 5)), numbers),
    d_hat_min=numbers,
    v_max=per_axis,
    a_max=per_axis,
    j_max=per_axis,
    theta_inverse=st.one_of(st.just(PUBLISHED_SCALING), scalings()),
    order=st.sampled_from([2, 3]),
    workspace=st.one_of(st.none(), boxes()),
    d_min=numbers,
    tracking_error=bounds,
)


def test_defaults_are_the_published_parameters() -> None:
    """Parameters() has the values of the published experiments, exactly."""
    published = Parameters()
    times_and_distances = [published.T_c, published.T_s, published.T_b, published.d_hat_min, published.d_min]
    assert times_and_distances == [Fraction(text) for text in ("0.1", "0.2", "0.2", "0.25", "0.12")]
    assert published.tracking_error == 0
    assert published.v_max == _vector("2", "2", "2")
    assert published.a_max == published.j_max == _vector("5", "5", "5")
    assert published.theta_inverse == (_vector("1", "0", "0"), _vector("0", "1", "0"), _vector("0", "0", "1/6"))
    assert published.order == 3
    assert published.workspace is None


def test_names_are_the_specified_ones() -> None:
    """The parameters have exactly the specified names, and then those of the extensions."""
    assert (*SPECIFIED_NAMES, *EXTENSIONS) == NAMES


CHANGES: list[tuple[str, dict[str, Any]]] = [
    ("T_c=0.05", {"T_c": Fraction(1, 20)}),
    ("T_c=+5e-2", {"T_c": Fraction(1, 20)}),
    ("T_c= 1/30 ", {"T_c": Fraction(1, 30)}),
    ("d_hat_min=.35", {"d_hat_min": Fraction(7, 20)}),
    ("d_min=0.123456789012345678901234567890", {"d_min": Fraction(12345678901234567890123456789, 10**29)}),
    ("v_max=1", {"v_max": _vector("1", "1", "1")}),
    ("v_max=1, 1, 0.5", {"v_max": _vector("1", "1", "0.5")}),
    ("a_max=0", {"a_max": _vector("0", "0", "0")}),
    ("j_max=100,1e2,1E+2", {"j_max": _vector("100", "100", "100")}),
    ("theta_inverse=1", {"theta_inverse": diagonal(_vector("1", "1", "1"))}),
    ("theta_inverse=1,1,1/2", {"theta_inverse": diagonal(_vector("1", "1", "0.5"))}),
    (
        f"theta_inverse={COUPLED}",
        {"theta_inverse": (_vector("2", "1", "0"), _vector("1", "2", "0"), _vector("0", "0", "0.5"))},
    ),
    ("order=2", {"order": 2}),
    (
        "workspace=-1.4,1.4,-3.7,3.7,0.4,1.8",
        {"workspace": (_range("-1.4", "1.4"), _range("-3.7", "3.7"), _range("0.4", "1.8"))},
    ),
    ("workspace=none", {"workspace": None}),
    ("tracking_error=0.02", {"tracking_error": Fraction(1, 50)}),
]


@pytest.mark.parametrize(("change", "expected"), CHANGES)
def test_a_change_is_read_exactly(change: str, expected: dict[str, Any]) -> None:
    """A NAME=VALUE text changes that parameter to exactly that value, in each of the allowed forms."""
    assert Parameters().with_changes([change]) == replace(Parameters(), **expected)


def test_a_file_is_read_exactly(tmp_path: Path) -> None:
    """All forms of a value in a TOML file are read without rounding; what the file does not name is published."""
    text = """
        T_c = 0.1          # 1/10 and not the nearest double
        T_s = "1/5"
        d_hat_min = 3_5.0e-2
        v_max = [1, "1/3", 0.5]
        a_max = "4,4,3"
        j_max = 0x64
        theta_inverse = [[2, 1, 0], [1.0, 2, 0], [0, 0, 0.5]]
        order = 2
        workspace = [[-1, 1], [-2, 2], [0, 1.8]]
    """
    read = Parameters.from_toml(_toml(tmp_path, text))
    assert (read.T_c, read.T_s, read.d_hat_min) == (Fraction(1, 10), Fraction(1, 5), Fraction(35, 100))
    assert read.v_max == _vector("1", "1/3", "0.5")
    assert read.a_max == _vector("4", "4", "3")
    assert read.j_max == _vector("100", "100", "100")
    assert read.theta_inverse == Parameters().with_changes([f"theta_inverse={COUPLED}"]).theta_inverse
    assert read.order == 2
    assert read.workspace == (_range("-1", "1"), _range("-2", "2"), _range("0", "1.8"))
    assert (read.d_min, read.tracking_error) == (Parameters().d_min, Fraction(0))


def test_a_file_may_write_the_diagonal_and_no_workspace(tmp_path: Path) -> None:
    """In a file as in a change, three numbers are the diagonal of Θ⁻¹, and the workspace can be none."""
    read = Parameters.from_toml(_toml(tmp_path, 'theta_inverse = [1, 1, "1/6"]\nworkspace = "none"\n'))
    assert read == Parameters()


def test_changes_come_after_the_file(tmp_path: Path) -> None:
    """A change overrides the file, and a later change an earlier one."""
    read = Parameters.from_toml(_toml(tmp_path, "T_c = 0.05\nd_min = 0.1\n"), ["T_c=0.02", "T_c=0.04"])
    assert (read.T_c, read.d_min) == (Fraction(1, 25), Fraction(1, 10))


def test_the_bounds_are_sampled_with_the_input_unless_said_otherwise(tmp_path: Path) -> None:
    """T_b is T_s where only T_s is given, and stays where it is given, be it in the file or by a change."""
    assert Parameters().with_changes(["T_s=0.4"]).T_b == Fraction(2, 5)
    assert Parameters().with_changes(["T_s=0.4", "T_b=0.1"]).T_b == Fraction(1, 10)
    assert Parameters().with_changes(["T_b=0.1"]).with_changes(["T_s=0.4"]).T_b == Fraction(1, 10)
    assert Parameters.from_toml(_toml(tmp_path, "T_s = 0.3"), ["T_s=0.4"]).T_b == Fraction(2, 5)
    assert Parameters.from_toml(_toml(tmp_path, "T_b = 0.2"), ["T_s=0.4"]).T_b == Fraction(1, 5)


SET_MISTAKES = [
    ("T_c", "'T_c' is not of the form NAME=VALUE"),
    ("Tc=0.1", "no parameter 'Tc': did you mean T_c?"),
    ("t_c=0.1", "did you mean T_c?"),
    ("vmax=1", "did you mean v_max?"),
    ("d_hat=0.3", "did you mean d_hat_min?"),
    ("xyz=1", "choose one of T_c, T_s,"),
    ("T_c=", "T_c: '' is not a number"),
    ("T_c=fast", "'fast' is not a number: write a decimal such as 0.1"),
    ("T_c=nan", "'nan' is not a number"),
    ("T_c=-inf", "'-inf' is not a number"),
    ("T_c=true", "'true' is not a number"),
    ("T_c=1_0", "'1_0' is not a number"),
    ("T_c=１", "is not a number"),
    ("T_c=0x10", "is not a number"),
    ("T_c=0.1/3", "is not a number"),
    ("T_c=1/0", "divides by zero"),
    ("T_c=1e999999", "out of range"),
    ("T_c=1e-999999", "out of range"),
    ("T_c=1e7", "between 1e-9 and 1e6"),
    ("T_c=1/9999999999", "out of range"),
    ("T_c=" + "1" * 101, "too long for a number"),
    ("T_c=" + "1," * 1001, "2002 characters"),
    ("T_c=1,2", "T_c takes one number"),
    ("T_c=0", "T_c must be positive, not 0"),
    ("T_s=-0.2", "T_s must be positive, not -0.2"),
    ("T_b=0", "T_b must be positive"),
    ("d_hat_min=0", "d_hat_min must be positive"),
    ("d_min=0", "d_min must be positive"),
    ("tracking_error=-1/3", "tracking_error must not be negative, as -1/3 is"),
    ("v_max=1,2", "v_max takes one number, or three"),
    ("v_max=" + "1," * 20 + "1", "v_max takes one number, or three"),
    ("v_max=1,-2,3", "v_max must not be negative on any axis, as -2 is"),
    ("a_max=-1", "a_max must not be negative"),
    ("j_max=-1", "j_max must not be negative"),
    ("theta_inverse=1,2", "theta_inverse takes 1 number, the 3 of its diagonal or all 9"),
    ("theta_inverse=0", "theta_inverse is singular"),
    ("theta_inverse=1,1,0", "theta_inverse is singular"),
    ("theta_inverse=1,1,0,1,1,0,0,0,1", "theta_inverse is singular"),
    ("theta_inverse=1,0,0,1,1,0,0,0,1", "theta_inverse is not symmetric"),
    ("theta_inverse=-1", "theta_inverse is not positive definite"),
    ("theta_inverse=-1,-1,1", "theta_inverse is not positive definite"),
    ("theta_inverse=1,2,0,2,1,0,0,0,1", "theta_inverse is not positive definite"),
    ("theta_inverse=1,0,0,0,1,2,0,2,1", "theta_inverse is not positive definite"),
    ("theta_inverse=1,2,0,2,1,0,0,0,-1", "theta_inverse is not positive definite"),
    ("order=4", "order is 2 (input acceleration) or 3 (input jerk), not 4"),
    ("order=2.5", "not 2.5"),
    ("workspace=0,1,0,1", "low and high for x, y and z, such as"),
    ("workspace=nothing", "workspace takes low and high for x, y and z"),
    ("workspace=0,1,2,-1,0,1", "workspace has a low y=2 above its high y=-1"),
]


@pytest.mark.parametrize(("change", "said"), SET_MISTAKES)
def test_a_mistaken_change_is_refused_in_one_sentence(change: str, said: str) -> None:
    """Whatever is wrong with a change, one line says that it is a --set, what is wrong and what would be right."""
    with pytest.raises(BadInput) as refusal:
        Parameters().with_changes([change])
    assert said in str(refusal.value)
    assert str(refusal.value).startswith("--set")
    assert str(refusal.value).isprintable()
    assert len(str(refusal.value)) < 250


FILE_MISTAKES = [
    ("T_c = true", "T_c: true is not a number"),
    ("T_c = nan", "'nan' is not a number"),
    ("T_c = +inf", "'+inf' is not a number"),
    ("T_c = 1e999999", "out of range"),
    ("T_c = 0x" + "F" * 9000, "an integer of many digits is out of range"),
    ("T_c = " + "9" * 9000, "far too many digits"),
    ("T_c = 2020-01-01", "is not a number"),
    ("T_c =", "is not TOML with lines such as T_c = 0.1"),
    ("T_c = 0.1\nT_c = 0.2", "is not TOML"),
    ("x = " + "[" * 20_000, "nested too deeply"),
    ("[margin]\nT_c = 0.1", "'margin' is a table, which is not a value"),
    ("v_max = {x = 1}", "'v_max' is a table"),
    ("v_max = [{x = 0x" + "F" * 9000 + "}, 1, 1]", "a table is not a number"),
    ("v_max = [[[1]], 1, 1]", "a list is not a number"),
    ("v_max = []", "v_max takes one number, or three"),
    ("v_max = [[1, 2, 3]]", "v_max takes one number, or three"),
    ("v_max = [true, 1, 1]", "v_max: true is not a number"),
    ("theta_inverse = [[1, 0], [0, 1]]", "theta_inverse takes 1 number"),
    ("theta_inverse = [[1, 0, 0, 0], [0, 1], [0, 0, 1]]", "theta_inverse takes 1 number"),
    ("workspace = [[0, 1], [0, 1]]", "workspace takes low and high"),
    ("workspace = [[0, 1, 0], [1, 0, 1]]", "workspace takes low and high"),
    ("workspace = false", "workspace takes low and high for x, y and z"),
    ("x = 1\n" * 20_000, "too long for a parameter file"),
]


@pytest.mark.parametrize(("text", "said"), FILE_MISTAKES)
def test_a_mistaken_file_is_refused_in_one_sentence(tmp_path: Path, text: str, said: str) -> None:
    """Whatever is wrong in a file, one line says which file, what is wrong and what would be right."""
    message = _mistake(tmp_path, text)
    assert said in message
    assert str(tmp_path / "parameters.toml") in message
    assert message.isprintable()


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    """A missing file, a folder and a file that is no text are bad input, not a traceback."""
    for path, said in ((tmp_path / "none.toml", "No such file"), (tmp_path, "directory")):
        with pytest.raises(BadInput, match="cannot read the parameter file") as refusal:
            Parameters.from_toml(path)
        assert said in str(refusal.value)
    (tmp_path / "picture.toml").write_bytes(b"\x89PNG\xff")
    with pytest.raises(BadInput, match="not a text file"):
        Parameters.from_toml(tmp_path / "picture.toml")


def test_an_absurd_exponent_costs_no_time() -> None:
    """An exponent is judged before the power of ten is built, which no machine could do."""
    with pytest.raises(BadInput, match="out of range"):
        read_number("1e" + "9" * 90)


def test_no_rounded_number_is_taken_for_an_exact_one() -> None:
    """A float, as a JSON file could contain, is refused."""
    with pytest.raises(BadInput, match="rounded number"):
        read_number(0.1)


def test_parameters_made_in_python_are_checked_too() -> None:
    """No way leads to parameters without a meaning."""
    with pytest.raises(BadInput, match="T_c must be positive"):
        Parameters(T_c=Fraction(0))
    with pytest.raises(BadInput, match="order is 2"):
        replace(Parameters(), order=1)


@SETTINGS
@given(st.text(max_size=40), st.sampled_from(NAMES))
def test_any_text_is_parameters_or_bad_input(text: str, name: str) -> None:
    """No text after NAME=, and no text at all, leads to another exception than BadInput."""
    for change in (f"{name}={text}", text):
        try:
            changed = Parameters().with_changes([change])
        except BadInput:
            continue
        assert isinstance(changed, Parameters)


@SETTINGS
@given(st.one_of(numbers, numbers.map(lambda value: -value), st.fractions(-1000, 1000, max_denominator=10**6)))
def test_a_number_survives_printing_and_reading(value: Fraction) -> None:
    """exact_text and read_number are inverse to each other."""
    assert read_number(exact_text(value)) == value


@pytest.mark.parametrize(
    ("value", "text"),
    [("1/6", "1/6"), ("0.05", "0.05"), ("2", "2"), ("-1.50", "-1.5"), ("100", "100"), ("0", "0"), ("1e-13", None)],
)
def test_numbers_are_printed_as_people_write_them(value: str, text: str | None) -> None:
    """A short decimal is printed as a decimal, everything else as a fraction."""
    assert exact_text(Fraction(value)) == (text or str(Fraction(value)))


@SETTINGS
@given(parameters)
def test_parameters_survive_their_exact_form(some: Parameters) -> None:
    """from_exact gives back what as_exact was made of, with three values a bound and a 3 x 3 matrix in between."""
    exact = some.as_exact()
    assert Parameters.from_exact(exact) == some
    assert list(exact) == list(SPECIFIED_NAMES)
    for values in (exact, some.as_json()):
        assert [len(values[name]) for name in ("v_max", "a_max", "j_max", "theta_inverse")] == [3, 3, 3, 3]
        assert [len(row) for row in values["theta_inverse"]] == [3, 3, 3]


def test_the_two_forms_of_the_published_parameters() -> None:
    """People get floats and the certificate gets exact texts; the order is an integer in both."""
    people, exact = Parameters().as_json(), Parameters().as_exact()
    assert (people["T_c"], people["v_max"], people["order"], people["workspace"]) == (0.1, [2.0, 2.0, 2.0], 3, None)
    assert (exact["T_c"], exact["v_max"], exact["order"], exact["workspace"]) == ("0.1", ["2", "2", "2"], 3, None)
    assert exact["theta_inverse"] == [["1", "0", "0"], ["0", "1", "0"], ["0", "0", "1/6"]]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"T_c": None}, "T_c: None is not a number"),
        ({"T_c": 0.1}, "rounded number"),
        ({"T_c": ["0.1", "0.2"]}, "T_c takes one number"),
        ({"T_d": "1"}, "no parameter 'T_d'"),
    ],
)
def test_a_mistaken_exact_form_is_refused(change: dict[str, object], said: str) -> None:
    """What as_exact would not have written is bad input."""
    with pytest.raises(BadInput, match="the parameters: ") as refusal:
        Parameters.from_exact(Parameters().as_exact() | change)
    assert said in str(refusal.value)


def test_an_incomplete_exact_form_is_refused() -> None:
    """The exact form has all parameters, so that none is silently the published one."""
    exact = Parameters().as_exact()
    del exact["T_c"], exact["order"]
    with pytest.raises(BadInput, match="the parameters lack T_c, order"):
        Parameters.from_exact(exact)


@SETTINGS
@given(parameters, st.one_of(st.just(Parameters()), parameters))
def test_differences_are_the_changes(some: Parameters, base: Parameters) -> None:
    """Applied to the base, the differences give the parameters back; there are none between equals."""
    assert base.with_changes(some.differences(base)) == some
    assert some.differences(some) == []


def test_parameters_are_described_by_what_is_special() -> None:
    """A description is short: equal axes are one number, a diagonal is three, a T_b that follows T_s is left out."""
    changes = ["T_c=0.05", "T_s=0.1", "v_max=1", "a_max=1,2,3", "theta_inverse=1"]
    assert Parameters().with_changes(changes).describe() == ", ".join(changes)
    assert Parameters().describe() == ""
    assert Parameters().with_changes(["T_b=0.1"]).describe() == "T_b=0.1"
    assert Parameters().with_changes(["theta_inverse=1,1,1/2"]).describe() == "theta_inverse=1,1,0.5"
    assert Parameters().with_changes([f"theta_inverse={COUPLED}"]).describe() == f"theta_inverse={COUPLED}"
    boxed = Parameters().with_changes(["workspace=-1,1,-2,2,0,1.8"])
    assert boxed.describe() == "workspace=-1,1,-2,2,0,1.8"
    assert Parameters().describe(boxed) == "workspace=none"


@pytest.mark.parametrize("changes", [[], ["T_c=0.2"], ["T_c=1/15"], ["T_c=0.0002"], ["T_b=0.05"]])
def test_as_sampled_takes_whole_periods(changes: list[str]) -> None:
    """T_c and T_b that divide T_s have a meaning as sampled."""
    Parameters().with_changes(changes).check_reading(Reading.AS_SAMPLED)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("T_c=0.03", "a whole multiple of T_c, at most 1000 times it: T_s=0.2 is 20/3 times T_c=0.03"),
        ("T_c=0.4", "T_s=0.2 is 0.5 times T_c=0.4"),
        ("T_c=0.0001", "T_s=0.2 is 2000 times T_c=0.0001"),
        ("T_b=0.15", "a whole multiple of T_b"),
        ("T_b=0.4", "T_s=0.2 is 0.5 times T_b=0.4"),
    ],
)
def test_only_as_sampled_minds_the_periods(change: str, said: str) -> None:
    """A T_c or T_b that does not divide T_s, or far too often, is refused as sampled and all the same otherwise."""
    changed = Parameters().with_changes([change])
    with pytest.raises(BadInput) as refusal:
        changed.check_reading(Reading.AS_SAMPLED)
    assert said in str(refusal.value)
    changed.check_reading(Reading.INITIAL_STATE)
    changed.check_reading(Reading.WHOLE_MOTION)


def test_the_readings_are_the_specified_ones() -> None:
    """There are three readings, found by their names, and no fourth."""
    assert list(Reading) == ["initial-state", "whole-motion", "as-sampled"]
    assert all(Reading.parse(reading) is reading for reading in Reading)
    with pytest.raises(BadInput, match="no reading 'sampled': choose initial-state, whole-motion or as-sampled"):
        Reading.parse("sampled")


OPEN: list[tuple[str, tuple[str | None, ...]]] = [
    ("-inf,inf,-1e9,1e9,-0.5,7", (None, None, None, None, "-0.5", "7")),
    ("none,2,-3,none,0,+inf", (None, "2", "-3", None, "0", None)),
    ("-1e7,1e7,0,1e-16,0,1", ("-1e7", "1e7", "0", "1e-16", "0", "1")),
]


@pytest.mark.parametrize(("text", "sides"), OPEN, ids=[text for text, _ in OPEN])
def test_a_side_of_the_space_may_be_open(text: str, sides: tuple[str | None, ...]) -> None:
    """``inf``, ``none`` and 1e9 are no limit; a coordinate may be as small as it likes."""
    low_high = [None if side is None else Fraction(side) for side in sides]
    read = Parameters().with_changes([f"workspace={text}"])
    assert read.workspace == tuple(zip(low_high[::2], low_high[1::2], strict=True))
    assert Parameters().with_changes(read.differences()) == read
    assert Parameters.from_exact(read.as_exact()) == read


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("inf,inf,0,1,0,1", "inf is no low: for no limit write [-inf, inf]"),
        ("-1,-inf,0,1,0,1", "-inf is no high"),
        ("0,1e-320,0,1,0,1", "has too many digits behind the point: 100 are the most, or write 0"),
        ("-2e7,1,0,1,0,1", "a coordinate is between -1e7 and 1e7 m; for no limit write inf"),
    ],
)
def test_a_side_that_cannot_be_is_refused(text: str, sentence: str) -> None:
    """An infinity on the wrong side, or a number between the largest coordinate and no limit, is a mistake."""
    with pytest.raises(BadInput) as refused:
        Parameters().with_changes([f"workspace={text}"])
    assert sentence in str(refused.value)


def test_a_bound_of_the_norm_brings_its_box() -> None:
    """Who bounds the norm only has the box around that ball; who gives both has both."""
    only = Parameters().with_changes(["v_norm=150"])
    assert (only.v_norm, only.v_max) == (Fraction(150), (Fraction(150),) * 3)
    both = Parameters().with_changes(["v_max=1.5", "v_norm=2"])
    assert (both.v_norm, both.v_max) == (Fraction(2), (Fraction(3, 2),) * 3)
    assert Parameters.from_exact(both.as_exact()) == both
    assert "v_norm" not in Parameters().as_exact()
    # in two steps, as a kind does with what is common to all: a box that was given stays, one that followed follows
    assert Parameters().with_changes(["v_max=2"]).with_changes(["v_norm=3"]).v_max == (Fraction(2),) * 3
    assert Parameters().with_changes(["v_norm=1"]).with_changes(["v_norm=3"]).v_max == (Fraction(3),) * 3


@pytest.mark.parametrize("text", ["none", "inf", "+inf"])
def test_a_norm_can_be_without_bound(text: str) -> None:
    """Where a bound is optional, an infinity means what none means; where it is not, it is no number."""
    assert Parameters().with_changes(["v_norm=1"]).with_changes([f"v_norm={text}"]).v_norm is None
    with pytest.raises(BadInput, match="is not a number"):
        Parameters().with_changes([f"T_c={text}"])


def test_a_box_that_nobody_gave_follows_the_norm_however_often_it_is_changed() -> None:
    """In a sweep, in a kind and in a search for the largest norm, no old box hides what the norm allows."""
    some = Parameters().with_changes(["v_norm=0.5"])
    assert some.v_max == (Fraction(1, 2),) * 3
    assert some.with_changes(["v_norm=3"]).v_max == (Fraction(3),) * 3
    assert some.with_table("a kind", {"v_norm": "3"}).v_max == (Fraction(3),) * 3
    assert changed(some, "v_norm", Fraction(3)).v_max == (Fraction(3),) * 3
    assert some.with_changes(["v_norm=none"]).v_max == Parameters().v_max
    own = Parameters().with_changes(["v_max=2", "v_norm=2"])
    assert own.with_changes(["v_norm=3"]).v_max == (Fraction(2),) * 3
    assert changed(own, "v_norm", Fraction(3)).v_max == (Fraction(2),) * 3
    assert "v_max" not in some.defaults()
    assert "v_max" in some.with_changes(["v_norm=none"]).defaults()


@pytest.mark.parametrize("changes", [["v_norm=3"], ["v_norm=3", "v_max=2"], ["v_norm=2", "v_max=2"], ["a_norm=5"]])
def test_what_is_written_of_a_norm_makes_the_same_parameters(changes: list[str]) -> None:
    """A box as published beside a norm is written down: without it, it would follow the norm."""
    some = Parameters().with_changes(changes)
    assert Parameters().with_changes(some.differences()) == some
    other = Parameters().with_changes(["v_norm=1", "T_c=0.05"])
    assert other.with_changes(some.differences(other)) == some
