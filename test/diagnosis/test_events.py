"""What happens in the middle of a recording is found, with its time; what does not is not made up."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest

from test.diagnosis import arms
from test.diagnosis.arms import PAIR, SHORT, diagnose, of_the_servos, of_the_wires, recorded
from trunk_ros.compiled import Array
from trunk_ros.diagnosis.search.credible import ends_within
from trunk_ros.diagnosis.search.windows import Prices, Reach, Sums, Window, best_course
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.effects import Effect, effect
from trunk_ros.effects.effect import Now

ALL = np.ones(3)
SECONDS = 24.0
on = partial(arms.on, joints=3)


def diagnosed(effects: dict[str, dict[str, Any]], seconds: float = SECONDS) -> Diagnosis:
    (stage,) = {effect(name).stage for name in effects}
    of_one, model = (of_the_wires, SHORT) if stage == "wire" else (of_the_servos, PAIR)
    return diagnose([of_one(recorded(effects, seconds, nominal=model))], model=model)


def test_a_screw_that_comes_loose_has_a_moment() -> None:
    said = diagnosed({"backlash": {"half_width": on(3, 2e-3), "from": 10.0 * ALL}})
    (finding,), (event,) = said.findings, said.events
    assert (finding.effect, finding.joints) == ("backlash", ["joint_3"])
    assert finding.parameters["joint_3"]["half_width"]["value"] == pytest.approx(2e-3, rel=0.02)
    assert (event.effect, event.joints, event.until) == ("backlash", ["joint_3"], None)
    assert event.begin is not None
    assert abs(event.begin - 10.0) < max(4 * (event.std or 0.0), 0.05)
    assert said.to_json()["events"][0]["from"] == event.begin


def test_a_payload_that_is_taken_up_and_put_down_is_one_payload() -> None:
    moments = {"payload": 0.1, "payload_from": 7.0, "payload_until": 17.0}
    said = diagnosed({"load_elasticity": {"compliance": 0.03 * ALL, **moments}})
    assert [f.effect for f in said.findings] == ["load_elasticity"]
    (event,) = said.events
    assert (event.begin, event.until) == (pytest.approx(7.0, abs=0.1), pytest.approx(17.0, abs=0.1))
    assert said.findings[0].parameters["arm"]["payload"]["value"] == pytest.approx(0.1, rel=0.05)


def test_a_wire_that_gives_way_more_and_more_grows() -> None:
    soft = {"compliance": on(2, 0.06), "from": 4.0 * ALL, "grown": 20.0 * ALL}
    said = diagnosed({"load_elasticity": soft})
    assert [(f.effect, f.joints) for f in said.findings] == [("load_elasticity", ["joint_2"])]
    (event,) = said.events
    assert (event.begin, event.grown) == (pytest.approx(4.0, abs=1.0), pytest.approx(20.0, abs=1.0))


@pytest.mark.parametrize(
    ("name", "values", "moment"),
    [
        ("servo_bandwidth", {"relative": -0.3}, "from"),
        ("servo_bandwidth", {"relative": arms.on(2, -0.3, joints=2), "form": "apart"}, "until"),
        ("servo_delay", {"delay": 0.03}, "until"),
        ("load_droop", {"gain": 0.02, "form": "weight"}, "from"),
        ("cogging", {"amplitude": 2e-3, "cycles_per_rev": 24.0, "phase": np.full(2, 0.5)}, "until"),
        ("sensor_delay", {"delay": 0.03}, "from"),
    ],
)
def test_what_becomes_of_servos_and_sensors_in_mid_run_has_a_moment(
    name: str, values: dict[str, Any], moment: str
) -> None:
    said = diagnosed({name: {**values, moment: 12.0}})
    (finding,), (event,) = said.findings, said.events
    assert (finding.effect, said.verdict) == (name, "explained")
    everywhere = SHORT if finding.stage == "wire" else PAIR
    assert finding.joints == (["joint_2"] if values.get("form") == "apart" else [*everywhere.arm.joints])
    assert {"from": event.begin, "until": event.until}[moment] == pytest.approx(12.0, abs=0.05)


def test_a_servo_that_becomes_slow_has_a_moment() -> None:
    said = diagnosed({"velocity_saturation": {"v_max": 0.4, "from": 15.0}}, 40.0)
    (finding,), (event,) = said.findings, said.events
    assert finding.parameters["arm"]["v_max"]["value"] == pytest.approx(0.4, rel=0.01)
    assert event.begin == pytest.approx(15.0, abs=0.1)


def test_what_is_there_from_beginning_to_end_is_no_event() -> None:
    said = diagnosed({"backlash": {"half_width": on(3, 2e-3)}, "ratio_error": {"relative": on(1, 0.02)}})
    assert {f.effect for f in said.findings} == {"backlash", "ratio_error"}
    assert said.events == []
    assert said.to_json()["events"] == []


def test_a_beginning_is_seen_by_a_joint_that_moves_before_and_after() -> None:
    stamp = np.arange(0.0, 40.0, 0.01)
    swing = np.sin(stamp)[:, None]
    loose = effect("backlash")({"half_width": np.full(1, 2e-3), "from": np.full(1, 20.0)})
    drawn = effect("joint_coupling")(
        {**effect("joint_coupling").null(), "gain": np.full(1, 0.1), "from": np.full(1, 20.0)},
        {"source": ("b",)},
    )

    def told(block: Effect, own: Array, other: Array) -> bool:
        both = np.column_stack([own, other])
        return ends_within(
            block, Now(stamp, 0.01 + 0 * stamp, own, own, own, both, both, ("a", "b"), np.ones(1))
        )

    late = np.where(stamp[:, None] > 25.0, swing, 0.0)
    assert told(loose, swing, late)
    assert not told(loose, late, swing)
    assert told(drawn, late, swing)


def test_a_slip_is_an_event() -> None:
    said = diagnosed({"wire_slip": {"step": on(2, 2e-3), "onset": 14.0 * ALL}})
    (event,) = said.events
    assert (event.effect, event.joints, event.begin) == (
        "wire_slip",
        ["joint_2"],
        pytest.approx(14.0, abs=0.05),
    )


@pytest.mark.parametrize(
    ("effects", "size", "moment", "times"),
    [
        ({"joint_coupling": {"gain": on(3, 0.01), "source": ["", "", "joint_2"]}}, 0.01, 12.0, -1.0),
        ({"load_elasticity": {"compliance": on(2, 0.03)}}, 0.03, 13.0, 2.0),
        ({"backlash": {"half_width": on(3, 2e-3)}}, 2e-3, 12.0, 2.5),
    ],
)
def test_what_changes_its_size_does_so_at_a_moment(
    effects: dict[str, dict[str, Any]], size: float, moment: float, times: float
) -> None:
    ((name, values),) = effects.items()
    said = diagnosed({name: {**values, "from_2": moment * ALL, "times_2": times * ALL}}, 2.0 * moment)
    (finding,), (event,) = said.findings, said.events
    assert (finding.effect, said.verdict) == (name, "explained")
    (found,) = finding.parameters.values()
    assert found[effect(name).parameters[0].name]["value"] == pytest.approx(size, rel=0.02)
    assert (event.begin, event.until) == (pytest.approx(moment, abs=0.05), None)
    assert event.times == said.to_json()["events"][0]["times"] == pytest.approx(times, rel=0.02)


def test_what_comes_twice_is_one_effect() -> None:
    moments = {"from": 5.0 * ALL, "until": 9.0 * ALL, "from_2": 15.0 * ALL, "until_2": 20.0 * ALL}
    said = diagnosed({"backlash": {"half_width": on(3, 2e-3), **moments}})
    assert [(f.effect, f.joints) for f in said.findings] == [("backlash", ["joint_3"])]
    assert [(e.begin, e.until) for e in said.events] == [
        (pytest.approx(5.0, abs=0.05), pytest.approx(9.0, abs=0.05)),
        (pytest.approx(15.0, abs=0.05), pytest.approx(20.0, abs=0.05)),
    ]


def test_two_weights_one_after_the_other_are_two_payloads_and_no_softer_wire() -> None:
    weights = {"payload": 0.1, "payload_from": 4.0, "payload_from_2": 13.0, "payload_times_2": 0.4}
    said = diagnosed({"load_elasticity": {"compliance": 0.03 * ALL, **weights}})
    assert [f.effect for f in said.findings] == ["load_elasticity"]
    assert [e.begin for e in said.events] == [pytest.approx(4.0, abs=0.1), pytest.approx(13.0, abs=0.1)]
    assert "payload of 0.0" in said.events[1].statement
    assert said.events[1].times == pytest.approx(0.4, abs=0.02)


def test_three_weights_one_after_the_other_are_none_in_between() -> None:
    said = diagnosed(
        {
            "load_elasticity": {
                "compliance": 0.03 * ALL,
                "payload": 0.1, "payload_from": 3.0, "payload_until": 7.0,
                "payload_from_2": 10.0, "payload_until_2": 14.0, "payload_times_2": 0.5,
                "payload_from_3": 17.0, "payload_times_3": 1.5,
            }
        }
    )  # fmt: skip
    assert [f.effect for f in said.findings] == ["load_elasticity"]
    assert [(e.begin, e.until, e.times) for e in said.events] == [
        (pytest.approx(3.0, abs=0.1), pytest.approx(7.0, abs=0.1), None),
        (pytest.approx(10.0, abs=0.1), pytest.approx(14.0, abs=0.1), pytest.approx(0.5, abs=0.03)),
        (pytest.approx(17.0, abs=0.1), None, pytest.approx(1.5, abs=0.05)),
    ]


def test_joints_whose_sizes_change_differently_are_told_apart() -> None:
    times = {"from_2": 12.0 * ALL, "times_2": np.array([1.0, 3.0, 6.0])}
    said = diagnosed({"backlash": {"half_width": on(2, 1e-3) + on(3, 1e-3), **times}})
    assert [(e.joints, e.times) for e in said.events] == [
        (["joint_2"], pytest.approx(3.0, rel=0.05)),
        (["joint_3"], pytest.approx(6.0, rel=0.05)),
    ]


def course_of(rest: Array, d: Array, prices: Prices, within: Reach = (-9.0, 9.0)) -> Window | None:
    stamp = np.linspace(0.0, 30.0, len(rest))
    return best_course([(stamp, rest, d, np.zeros((len(rest), 0)))], stamp, within, prices)


@pytest.mark.parametrize("grows", [False, True])
def test_the_look_at_all_windows_is_that_at_each(grows: bool) -> None:
    """Sums from edge to edge against the same products with the change masked."""
    rng = np.random.default_rng(2)
    stamp = np.linspace(0.0, 30.0, 1500)
    rest, d = rng.normal(size=1500), rng.normal(size=1500)
    q = np.linalg.qr(rng.normal(size=(1500, 2)))[0]
    edges = np.linspace(1.0, 29.0, 100)
    sums = Sums.of(edges, stamp, rest, d, q)
    rd, dd = sums.growing() if grows else sums.between()
    i, j = 21, 64
    if grows:
        # what grows goes on until the end, which an edge at infinity is
        sums = Sums.of(np.append(edges, np.inf), stamp, rest, d, q)
        rd, dd = sums.growing()
        shape = np.clip((stamp - edges[i]) / (edges[j] - edges[i]), 0.0, 1.0)
    else:
        shape = (stamp >= edges[i]) & (stamp < edges[j])
    masked = shape * d
    assert rd[i, j] == pytest.approx(rest @ masked, abs=1e-6)
    assert dd[i, j] == pytest.approx(masked @ masked - np.sum((q.T @ masked) ** 2), abs=1e-6)


def test_the_best_window_is_where_the_change_was() -> None:
    rng = np.random.default_rng(3)
    stamp = np.linspace(0.0, 30.0, 1500)
    d = np.sin(stamp)
    rest = np.where((stamp > 9.0) & (stamp < 21.0), 3.0 * d, 0.0) + rng.normal(size=1500)
    found = course_of(rest, d, Prices(60.0, 20.0))
    assert found is not None
    assert found.moments == {"from": pytest.approx(9.0, abs=0.7), "until": pytest.approx(21.0, abs=0.7)}
    assert found.size == pytest.approx(3.0, abs=0.2)
    assert course_of(rng.normal(size=1500), d, Prices(60.0, 20.0)) is None


def test_sizes_one_after_the_other_are_found_one_window_after_the_other() -> None:
    rng = np.random.default_rng(4)
    stamp = np.linspace(0.0, 30.0, 3000)
    d = np.sin(3.0 * stamp)
    sizes = np.select([stamp < 6.0, stamp < 12.0, stamp < 20.0], [0.0, 4.0, 0.0], 2.0)
    found = course_of(sizes * d + rng.normal(size=3000), d, Prices(60.0, 20.0))
    assert found is not None
    assert found.moments == {
        "from": pytest.approx(6.0, abs=0.4),
        "until": pytest.approx(12.0, abs=0.4),
        "from_2": pytest.approx(20.0, abs=0.4),
        "times_2": pytest.approx(0.5, abs=0.1),
    }
    assert found.size == pytest.approx(4.0, abs=0.2)


def test_what_is_only_as_it_is_has_no_second_size() -> None:
    stamp = np.linspace(0.0, 30.0, 3000)
    d = np.sin(3.0 * stamp)
    twofold = np.where(stamp < 15.0, 1.0, 2.0) * d
    found = course_of(twofold, d, Prices(60.0, 20.0), within=(1.0, 1.0))
    assert found is None or not {"from_2", "times_2"} & set(found.moments)
