"""The report's figures: curves that show what was found, and numbers as readers write them."""

import re

import matplotlib as mpl
import numpy as np
import pytest

from test.diagnosis import made
from trunk_ros.diagnosis.report import figure_before_after, render
from trunk_ros.diagnosis.report.errors import culprit_spans, figure_over_time, shown_over_time
from trunk_ros.diagnosis.report.signals import contributions, reversals, signals
from trunk_ros.diagnosis.report.units import powers, quantity
from trunk_ros.diagnosis.report.view import cloud, view_of
from trunk_ros.diagnosis.verdict.result import Diagnosis


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    return made.backlash()


@pytest.mark.parametrize(
    ("value", "std", "unit", "text"),
    [
        (0.0123, 0.0004, "s", "12.30 ± 0.40 ms"),
        (0.21, None, "rad", "12.0 °"),
        (-2e-5, 1e-6, "rad", "−20.0 ± 1.0 µrad"),
        (0.6159, 0.001, "rad/s", "0.6159 ± 0.0010 rad/s"),
        (0.0279, None, "rad/(N*m)", "27.9 mrad/(N·m)"),
        (0.0638, 0.0008, "kg", "63.80 ± 0.80 g"),
        (float("nan"), None, "rad", "–"),
        ("joint_1", None, "", "joint_1"),
        (0.0, 0.0, "m", "0 µm"),
    ],
)
def test_quantities_are_written_as_in_the_field(
    value: object, std: float | None, unit: str, text: str
) -> None:
    assert quantity(value, std, unit).replace("\N{NO-BREAK SPACE}", " ") == text


def test_large_losses_have_powers_of_ten() -> None:
    assert powers(15628181.0) == "1.6\N{NO-BREAK SPACE}×\N{NO-BREAK SPACE}10⁷"


def test_culprit_spans_are_where_the_nominal_error_is_well_above_the_noise() -> None:
    result = made.diagnosis({}, [])
    held = result.plots["wire", "joint_1"]
    more = np.where((held["stamp"] > 20) & (held["stamp"] < 30), 1e-3, 0.0)
    held |= {key: held[key] + more for key in ("measured", "error_before", "error_after")}
    assert culprit_spans(signals(result)[0]) == [pytest.approx((20.0, 30.0), abs=0.6)]
    assert culprit_spans(signals(result)[1]) == []


def test_the_signature_of_a_backlash_turns_from_plus_to_minus_its_width(
    found: Diagnosis,
) -> None:
    signal = next(s for s in signals(found) if s.name == "joint_3")
    view = view_of(found.findings[0], "joint_3")
    part = contributions(found, found.findings[0])["joint_3"]
    shown = cloud(found, view, signal, part)
    assert shown.y_label == "residual along the motion / mrad"
    assert shown.curve_y[0] == pytest.approx(1.0, abs=0.3)
    assert shown.curve_y[-1] == pytest.approx(-1.0, abs=0.01)
    late = shown.y[shown.x > 10]
    assert float(late.mean()) == pytest.approx(-1.0, abs=0.05)


def test_two_effects_on_one_joint_are_drawn_apart() -> None:
    ratio = made.finding("ratio_error", ["joint_3"], {"joint_3": {"relative": made.value(0.01, 1e-5, "1")}})
    width = made.backlash().findings[0]
    only = np.array([0.0, 0.0, 1.0, 0.0, 0.0])
    both = {"ratio_error": {"relative": 0.01 * only}, "backlash": {"half_width": 1e-3 * only}}
    result = made.diagnosis(both, [ratio, width])
    signal = signals(result)[2]
    shown = cloud(result, view_of(ratio, "joint_3"), signal, contributions(result, ratio)["joint_3"])
    slope = np.polyfit(np.radians(shown.x), 1e-3 * shown.y, 1)[0]
    assert slope == pytest.approx(0.01, rel=0.02)
    assert np.ptp(contributions(result, width)["joint_3"]) == pytest.approx(2e-3, rel=0.1)


def test_travel_starts_anew_at_each_reversal_and_noise_is_none() -> None:
    u = np.concatenate([np.linspace(0, 1, 101), np.linspace(1, 0, 101)[1:]])
    direction, travel = reversals(u + 1e-5 * np.random.default_rng(0).standard_normal(len(u)))
    assert np.all(direction[:100] == 1)
    assert np.all(direction[102:] == -1)
    assert travel[-1] == pytest.approx(1.0, abs=1e-3)
    assert travel[102] == pytest.approx(0.02, abs=1e-3)


def test_errors_of_zero_are_drawn_at_half_the_noise_without_a_warning(
    recwarn: pytest.WarningsRecorder,
) -> None:
    result = made.diagnosis({}, [])
    for said in result.stages["wire"]["joints"].values():
        said |= {"rmse_before": 0.0, "rmse_after": 0.0}
    axis = figure_before_after(result).axes[0]
    assert 0.3 < axis.get_xlim()[0] < 0.5
    assert not recwarn.list


def test_drawing_leaves_no_trace_in_matplotlib(found: Diagnosis) -> None:
    before = dict(mpl.rcParams)
    figure = figure_before_after(found)
    render(found)
    assert dict(mpl.rcParams) == before
    assert len(figure.axes) == 1
    pyplot = pytest.importorskip("matplotlib.pyplot")
    assert pyplot.get_fignums() == []


def test_the_residual_over_time_says_what_its_axis_is(found: Diagnosis) -> None:
    figure = figure_over_time(shown_over_time(found))
    assert figure.get_supylabel() == "residual"
    assert {axis.get_ylabel() for axis in figure.axes} == {"mrad"}


def test_whatever_may_be_wider_than_the_page_shows_a_shadow_where_it_goes_on(found: Diagnosis) -> None:
    page = render(found)
    sideways = re.findall(r"^\s*([^{}@]+?) \{[^}]*overflow-x: auto", page, re.MULTILINE)
    (shaded,) = re.findall(r"^([^{}@]+?) \{[^}]*var\(--shade\), transparent", page, re.MULTILINE)
    assert set(sideways) == set(shaded.split(", "))
