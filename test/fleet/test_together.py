"""What many recordings say together, on tables with something hidden in them."""

import numpy as np
import pytest

pytest.importorskip("ruptures")

from test.concealed import fleet_tables as tables
from trunk_ros.fleet.together.arm_effects import chosen, claims, followed, on_joints
from trunk_ros.fleet.together.correction import stands
from trunk_ros.fleet.together.judged import judged
from trunk_ros.fleet.together.moderated import prior
from trunk_ros.fleet.together.series import DAY, Key, Series, collected, travels_of
from trunk_ros.fleet.together.summary import summarised

JOINTS = tuple(f"joint_{k}" for k in range(1, 6))
N = 24


def series(value, std=1e-5, arm="a", travel=None):
    n = len(value)
    rng = np.random.default_rng(len(value) + sum(map(ord, arm)))
    time = 1e9 + np.arange(n) * DAY
    noisy = np.asarray(value) + rng.normal(size=n) * std
    metres = np.full(n, np.nan) if travel is None else travel
    return Series(Key(arm, "backlash", "joint_2", "half_width"), "rad", time, metres, noisy, np.full(n, std))


def summary(*many, limits=None):
    return summarised(list(many), {one.key.arm: len(one.value) for one in many}, [], limits)


def others(count=5):
    return [series(np.full(N, 1e-4), arm=f"still {k}") for k in range(count)]


def test_what_grows_is_a_trend_over_days_and_metres_with_the_truth_in_its_interval():
    run = np.linspace(0.0, 50.0, N)
    fleet = summary(series(1e-4 + 2e-6 * run, travel=run), *others())
    assert [(t.arm, t.per) for t in fleet.trends] == [("a", "day"), ("a", "m")]
    over_metres = fleet.trends[1]
    assert over_metres.interval[0] < 2e-6 < over_metres.interval[1]
    assert not fleet.changes


def test_growth_that_began_one_day_is_dated_and_its_limit_foreseen():
    days = np.arange(N)
    fleet = summary(
        series(1e-4 + 1e-5 * np.maximum(days - 10, 0)), *others(), limits={("backlash", "half_width"): 4e-4}
    )
    [trend] = fleet.trends
    assert abs((trend.since - 1e9) / DAY - 10) <= 1
    when, first, last = trend.crosses
    assert first < when < last
    assert abs((when - 1e9) / DAY - 40) < 1.5


def test_a_jump_is_a_change_on_its_day_and_no_trend():
    fleet = summary(series(1e-4 + 1e-4 * (np.arange(N) >= 15)), *others())
    [change] = fleet.changes
    assert not fleet.trends
    assert 14 < (change.time - 1e9) / DAY < 15
    assert change.std == pytest.approx(DAY / np.sqrt(12), rel=0.1)
    assert change.step == pytest.approx(1e-4, rel=0.1)


@pytest.mark.parametrize("at", [0, 11, N - 1])
def test_one_odd_recording_is_neither(at):
    value = np.full(N, 1e-4)
    value[at] = 2e-3
    fleet = summary(series(value), *others())
    assert (fleet.trends, fleet.changes) == ([], [])


def test_few_recordings_say_nothing_of_a_life():
    assert summary(series([1e-4, 2e-4, 3e-4, 4e-4])).found == []


def test_what_all_arms_show_is_common_and_the_odd_one_stands_out():
    many = [series(np.full(N, 1e-4), arm=f"arm {k}") for k in range(8)]
    fleet = summary(*many, series(np.full(N, 5e-4), arm="odd"))
    [common] = fleet.common
    assert (common.arms, common.of) == (9, 9)
    assert common.interval[0] < 1e-4 < common.interval[1]
    assert [own.arm for own in fleet.own] == ["odd"]


def test_a_fleet_with_hidden_wear_slips_and_payloads_is_read_and_a_still_one_says_nothing():
    table = tables.made(3, arms=15)
    arms = {f"arm_{k:02d}": 30 for k in range(15)}
    fleet = summarised(collected(table.rows, {}), arms, [])
    found = tables.trends_scored(table, fleet.trends) + tables.changes_scored(table, fleet.changes)
    assert found.f1 >= 0.9
    assert found.false == 0
    assert {own.arm for own in fleet.own if own.effect == tables.PULLEY} >= set(table.batch)
    still = summarised(collected(tables.made(4, arms=15, still=True).rows, {}), arms, [])
    assert (still.trends, still.changes) == ([], [])


def test_variances_of_short_series_are_drawn_to_those_of_the_others():
    rng = np.random.default_rng(0)
    alike = rng.chisquare(4, 200) / 4 * 2.0
    told = prior(alike, np.full(200, 4.0))
    assert told.variance == pytest.approx(2.0, rel=0.15)
    assert told.dof > 20, "they differ by no more than four degrees of freedom make them"
    wild = alike * np.exp(rng.normal(0, 1.0, 200))
    assert prior(wild, np.full(200, 4.0)).dof < 6


def test_the_correction_grows_with_the_number_looked_at():
    assert stands([1e-3]).tolist() == [True]
    assert not stands([1e-3, *[0.5] * 99]).any()


def test_travel_is_summed_over_an_arms_recordings_in_the_order_of_time():
    rows = [
        {"arm": "a", "time": 2.0, "path": "second", "travel": [{"joint": "j", "metres": 5.0}]},
        {"arm": "a", "time": 1.0, "path": "first", "travel": [{"joint": "j", "metres": 3.0}]},
    ]
    told = travels_of(rows)
    assert (told["first", "j"], told["second", "j"], told["second", "arm"]) == (0.0, 3.0, 3.0)


def finding(effect, joint, path, value=1e-3, parameter="half_width", confidence=0.9, **other):
    return {
        "arm": "a", "stage": "wire", "effect": effect, "joint": joint, "path": path, "value": value,
        "parameter": parameter, "confidence": confidence, "word": None, "form": "", "equivalents": [], **other
    }  # fmt: skip


def test_the_arms_effects_are_those_of_several_recordings_under_the_name_that_most_give_them():
    rows = [finding("backlash", "joint_2", f"run {k}") for k in range(4)]
    rows += [
        finding("presliding_hysteresis", "joint_2", "run 5", 2e-3, "width", equivalents=["backlash"]),
        finding("presliding_hysteresis", "joint_2", "run 6", 2e-3, "width", equivalents=["backlash"]),
        finding("zero_offset", "joint_3", "run 1", 1e-3, "offset"),
    ]
    own = chosen(claims(rows), 10)
    assert set(own) == {("backlash", "joint_2")}
    [values] = on_joints(followed(own), JOINTS).values()
    assert values["half_width"].tolist() == [0.0, 1e-3, 0.0, 0.0, 0.0]


def test_judged_series_keep_their_names_where_recordings_stand_apart():
    value = np.full(N, 1e-4)
    value[5] = 1.0
    one = series(value)
    [told] = judged([one])
    assert len(told.series.value) == N - 1
