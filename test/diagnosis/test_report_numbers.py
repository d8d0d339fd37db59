"""Numbers that people read: three digits, or as many as a spread tells; no value that nothing determines."""

import re
from dataclasses import replace

import pytest
from rich.console import Console

from test.diagnosis import made
from test.diagnosis.made import page_of
from test.diagnosis.test_report import words
from trunk_ros.diagnosis.report.data import numbers
from trunk_ros.diagnosis.report.units import fall, powers, rounded, times
from trunk_ros.diagnosis.verdict.finding import evidence_of
from trunk_ros.diagnosis.verdict.findings import statement_of
from trunk_ros.evaluate.score import Row
from trunk_ros.evaluate.table import show
from trunk_ros.units import as_read
from trunk_ros.words import significant


@pytest.mark.parametrize(
    ("value", "std", "unit", "text"),
    [
        (0.5843, 8.7e3, "s", "not determined"),
        (0.05324, 0.12365, "1", "0.05 ± 0.12"),
        (-0.02, 0.05, "rad", "-0.02 ± 0.05 rad"),
        (1e-4, 0.02, "rad", "0.0001 ± 0.02 rad"),
        (0.0, 0.0004, "1", "0 ± 0.0004"),
        (0.029994, 2.6e-5, "rad", "0.029994 ± 2.6e-05 rad"),
        (0.0, None, "m", "0 m"),
        (-0.002, 15.0, "m", "not determined"),
        (2.0, 15.0, "rad", "2 ± 15 rad"),
    ],
)
def test_a_value_that_is_far_less_than_its_spread_is_not_told(
    value: float, std: float | None, unit: str, text: str
) -> None:
    assert as_read({"value": value, "std": std, "unit": unit}) == text


def test_sentence_and_table_of_the_page_tell_what_is_determined_and_the_file_the_numbers() -> None:
    parameters = {
        "joint_3": {"gain": made.value(0.05, 0.12, "1")},
        "arm": {"time_constant": made.value(0.58, 8.7e3, "s")},
    }
    said = statement_of("It creeps", "joint_3", parameters)
    assert said.endswith("(joint_3 gain = 0.05 ± 0.12; arm time_constant not determined).")
    creep = made.finding("viscoelastic_creep", ["joint_3"], parameters, statement=said)
    result = replace(made.backlash(), findings=[creep])
    text = words(page_of(result))
    assert "shared not determined" in text
    assert "8.7" not in text.partition("What was found")[2].partition("Still unexplained")[0]
    assert result.to_json()["findings"][0]["parameters"]["arm"]["time_constant"]["std"] == 8.7e3


def test_of_a_lag_that_is_less_than_its_spread_a_bound_is_told() -> None:
    rows = {row["signal"]: row for row in numbers(made.backlash())}
    assert re.fullmatch(r"under 0\.\d+ ms", rows["wire · joint_3"]["lag_after"])
    assert " ± " in rows["wire · joint_3"]["lag_before"]


def test_three_digits_at_most() -> None:
    thin = "\N{NARROW NO-BREAK SPACE}"
    assert [times(x) for x in (0.98, 15.43, 1341.0, 15816124.1)] == [
        "1.0", "15.4", f"1{thin}340", f"15{thin}800{thin}000",
    ]  # fmt: skip
    assert [significant(x) for x in (1896.4, 0.5843, 9.999)] == ["1900", "0.584", "10.0"]
    assert powers(1896.4) == "1900"


def test_what_is_small_beside_another_is_told_in_its_own_multiple() -> None:
    assert fall(0.0162, 3.6e-10, "rad").replace("\N{NO-BREAK SPACE}", " ") == "16.2 mrad → 0.36 nrad"
    assert fall(0.00465, 9.5e-5, "rad").replace("\N{NO-BREAK SPACE}", " ") == "4.65 → 0.095 mrad"
    assert rounded(3e-10, "rad", 0.0162).replace("\N{NO-BREAK SPACE}", " ") == "0.300 nrad"


def test_of_signals_without_noise_nothing_is_told_in_times_of_it() -> None:
    result = made.backlash()
    for said in result.stages["wire"]["joints"].values():
        said |= {"noise_floor": 1e-9, "rmse_after": 4e-10}
    text = words(page_of(result))
    assert "1.00 mrad → 0.40 nrad" in re.sub(r"0\.9\d+ mrad", "1.00 mrad", text)
    assert "× noise, " not in text
    assert not re.search(
        r"(?<!more than )\d times the noise|mean squared residual rises by \d|\d × noise", text
    )


def test_of_what_no_curve_fits_no_size_and_no_contribution_is_told() -> None:
    told = evidence_of(signature="No effect and no curve explains it.")
    unknown = made.finding("unknown", ["joint_3"], {}, depends_on=["speed"], evidence=told)
    text = words(page_of(replace(made.backlash(), findings=[unknown])))
    assert "no curve fits" in text
    assert "Grey dots: residual. What to look for" in text
    assert "It moves the prediction" not in text
    assert "a curve over" not in text


def test_an_error_that_no_finding_changes_is_told_once() -> None:
    result = made.backlash()
    for said in result.stages["wire"]["joints"].values():
        said["rmse_after"] = said["rmse_before"]
    assert re.search(
        r"Held-out error of the worst signal, wire joint_3: [^→]* mrad, as before", words(page_of(result))
    )


def test_evaluate_shows_no_ratio_to_noise_that_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    row = Row("run", "trunk", "wire", "joint_1", "rad", 0.01, 0.01, 0.02, 0.02, 1e-9)
    show([row, replace(row, joint="joint_2", noise=1e-4), replace(row, model="m")], Console(width=160))
    told = capsys.readouterr().out.splitlines()
    assert [line.split()[-1] for line in told[1:4]] == ["–", "100", "–"]
    assert "≈ 0" in told[1]
    show([replace(row, rms_after=1.43)], Console(width=160))
    assert "1430 mrad" in capsys.readouterr().out
    assert "no signal has noise" in told[-1]


def test_what_a_decision_takes_is_explained_once() -> None:
    one = {"separates": ["backlash", "tension_error"], "statement": "10% of what a decision takes."}
    page = page_of(replace(made.backlash(), experiments=[one | {"trajectory": ""}] * 2))
    assert page.count("A decision takes so large a difference") == 1
    page = page_of(replace(made.backlash(), experiments=[one | {"trajectory": "a.yaml"}]))
    assert "A decision takes" not in page
