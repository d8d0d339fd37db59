"""Effects that begin, grow and end in mid-run, against the same effects that act all the time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from test.effects.example import alike, arm_of, motion, stamps
from trunk_ros.arm import Arm
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.effects import effect, lasting, registry
from trunk_ros.effects.moments import RISE, share
from trunk_ros.errors import ModelError
from trunk_ros.model import Model, load_model, save_model

STAMP = stamps(20, 200)
THETA = motion(STAMP, 3)
PHI = THETA / 0.625
BEFORE, AFTER = STAMP < 7.9, STAMP > 12.1

BEGINNING: dict[str, dict[str, Any]] = {
    "ratio_error": {"relative": np.full(3, 0.02)},
    "load_elasticity": {"compliance": np.array([0.0, 0.02, 0.03])},
    "load_dependent_friction": {"gain": np.full(3, 0.01)},
    "backlash": {"half_width": np.full(3, 2e-3)},
    "tension_error": {"factor": 3.0},
    "wire_stiffening": {"compliance": np.full(3, 0.03), "moment": np.full(3, 0.1)},
}


class Seeing(NamedTuple):
    stamp: Array
    ratio: Array = np.ones(1)


def wire(effects: dict[str, dict[str, Any]], dead_band: float = 1e-3) -> Array:
    return Chain(Model(arm_of(3, dead_band), effects), "wire").run(PHI, STAMP)[0]


@pytest.mark.parametrize("name", BEGINNING)
def test_it_is_absent_before_it_begins_and_whole_afterwards(name: str) -> None:
    """In all joints but for the friction element's memory, which is gone after a turn on either side."""
    always, never = wire({name: BEGINNING[name]}, 1e-9), wire({}, 1e-9)
    shared = effect(name).moments()[0].shared
    begun = wire({name: {**BEGINNING[name], "from": 10.0 if shared else np.full(3, 10.0)}}, 1e-9)
    assert begun[BEFORE] == pytest.approx(never[BEFORE], abs=1e-12)
    far = np.abs(always - never).max()
    assert np.abs((begun - always)[AFTER]).max() < 1e-3 * far + 1e-12 or np.median(
        np.abs((begun - always)[AFTER])
    ) == pytest.approx(0.0, abs=1e-12)
    assert np.abs((begun - never)[AFTER]).max() > 0.3 * far


def test_each_joint_has_moments_of_its_own() -> None:
    bent = {
        "relative": np.full(3, 0.02),
        "from": np.array([0.0, 10.0, 10.0]),
        "until": np.array([10.0, 1e6, 15.0]),
    }
    share = (wire({"ratio_error": bent}, 0.0) - wire({}, 0.0))[1:] / (0.02 * THETA[1:])
    for t, there in ((5.0, (1, 0, 0)), (12.5, (0, 1, 1)), (17.5, (0, 1, 0))):
        k = int(np.searchsorted(STAMP[1:], t))
        assert share[k] == pytest.approx(there, abs=1e-9)


def test_what_grows_does_so_in_proportion_to_the_time() -> None:
    soft = {"compliance": np.full(3, 0.02)}
    grows = soft | {"from": np.full(3, 5.0), "grown": np.full(3, 15.0)}
    some, whole = (wire({"load_elasticity": values}, 0.0) - wire({}, 0.0) for values in (grows, soft))
    expected = np.clip((STAMP - 5.0) / 10.0, 0.0, 1.0)
    alike(some, expected[:, None] * whole, 1e-5)


def test_a_payload_is_carried_from_when_it_is_taken_up_until_it_is_put_down() -> None:
    soft = {"compliance": np.full(3, 0.03)}
    empty, loaded = (wire({"load_elasticity": soft | {"payload": mass}}, 0.0) for mass in (0.0, 0.2))
    moments = {"payload": 0.2, "payload_from": 8.0, "payload_until": 12.0}
    carried = wire({"load_elasticity": soft | moments}, 0.0)
    there = (STAMP > 8.1) & (STAMP < 11.9)
    assert carried[BEFORE | AFTER] == pytest.approx(empty[BEFORE | AFTER], abs=1e-7)
    assert carried[there] == pytest.approx(loaded[there], abs=1e-7)
    assert np.abs((loaded - empty)[there]).max() > 1e-3


def test_the_inverse_knows_when() -> None:
    effects = {
        "load_elasticity": {
            "compliance": np.full(3, 0.02),
            "from": np.full(3, 8.0),
            "until": np.full(3, 12.0),
        }
    }
    chain = Chain(Model(arm_of(3, 0.0), effects), "wire")
    shown, _ = chain.run(PHI, STAMP)
    back, _ = chain.invert(shown, STAMP)
    apart = np.abs(STAMP[:, None] - np.array([8.0, 12.0])).min(axis=1) > 0.05
    assert back[apart] == pytest.approx(PHI[apart], abs=1e-7)


def test_live_nodes_have_the_model_as_it_is_at_the_end() -> None:
    """What has ended is gone, what has begun lasts, what still grows is as large as it has become."""
    effects = {
        "backlash": {
            "half_width": np.full(3, 2e-3),
            "from": np.array([0.0, 10.0, 0.0]),
            "until": np.array([9.0, 1e6, 1e6]),
        },
        "load_elasticity": {
            "compliance": np.full(3, 0.03),
            "grown": np.full(3, 40.0),
            "payload": 0.2,
            "payload_until": 12.0,
        },
    }
    there = Model(arm_of(3), effects, duration=20.0).at_end()
    assert there.effects["backlash"]["half_width"].tolist() == [0.0, 2e-3, 2e-3]
    assert there.payload == 0.0
    assert there.effects["load_elasticity"]["compliance"] == pytest.approx(0.015)
    assert not any({"from", "until", "grown"} & set(values) for values in there.effects.values())


def test_a_model_file_keeps_the_moments(tmp_path: Path) -> None:
    effects = {
        "backlash": {"half_width": np.full(5, 2e-3), "from": np.full(5, 3.25), "until": np.full(5, 9.5)}
    }
    nominal = load_model("trunk")
    save_model(Model(nominal.arm, effects, duration=20.0), tmp_path / "model.yaml")
    kept = load_model(tmp_path / "model.yaml").effects["backlash"]
    assert kept["from"].tolist() == [3.25] * 5
    assert kept["until"].tolist() == [9.5] * 5


def test_effects_that_cannot_begin_say_so(tmp_path: Path) -> None:
    (tmp_path / "model.yaml").write_text(
        "/**:\n  ros__parameters:\n    effects:\n      zero_offset: {offset: [0.01], from: [3.0]}\n"
    )
    with pytest.raises(ModelError, match=r"effects\.zero_offset\.from"):
        load_model(tmp_path / "model.yaml")
    assert all(kind.stage != "arm" and kind.named for kind in registry().values() if kind.begins)


def test_what_comes_again_has_the_size_of_then() -> None:
    soft, hard = {"compliance": np.full(3, 0.02)}, {"compliance": np.full(3, 1e-9)}
    moments = {
        "until": np.array([1e6, 5.0, 1e6]),
        "from_2": np.array([10.0, 12.0, 1e6]),
        "times_2": np.array([2.5, 1.0, 1.0]),
    }
    some, whole, none = (wire({"load_elasticity": v}, 1e-9) for v in (soft | moments, soft, hard))
    for t, sizes in ((4.0, (1.0, 1.0, 1.0)), (8.0, (1.0, 0.0, 1.0)), (16.0, (2.5, 1.0, 1.0))):
        k = int(np.searchsorted(STAMP, t))
        assert (some - none)[k] == pytest.approx(np.array(sizes) * (whole - none)[k], rel=0.05, abs=1e-5)


def test_at_the_end_a_model_has_the_last_size() -> None:
    values = {"compliance": np.full(3, 0.02), "payload": 0.1, "payload_from_2": 8.0, "payload_times_2": 0.4}
    moments = {"from_2": np.full(3, 10.0), "times_2": np.array([2.0, 1.0, 0.5])}
    model = Model(arm_of(3, 1e-3), {"load_elasticity": values | moments}, duration=20.0)
    there = model.at_end().effects["load_elasticity"]
    assert there["compliance"] == pytest.approx([0.04, 0.02, 0.01])
    assert there["payload"] == pytest.approx(0.04)
    assert set(there) == {"compliance", "payload", "form"}


@pytest.mark.parametrize("form", ["held", "links"])
def test_what_is_taken_up_has_mass_for_links_that_swing(form: str) -> None:
    """From soon after the beginning on it is as if it had always been there, and back again."""
    arm, mass = arm_of(3, 1e-3), 0.3

    def swung(payload: float, **when: float) -> Array:
        always = payload if not when else 0.0  # frequency and damping are those with what the arm always has
        slow = 1.0 / np.sqrt(replace(arm, payload=arm.payload + always).straight_inertia)
        soft = {"compliance": np.full(3, 0.03), "payload": payload, **when}
        if form == "held":
            return run(arm, {"load_elasticity": {**soft, "damping": 0.05 * slow, "form": "held"}})
        links = {"frequency": 0.5 * slow, "damping": 0.05 * slow, "form": "links"}
        return run(arm, {"load_elasticity": soft, "link_resonance": links})

    def run(arm: Arm, effects: dict[str, dict[str, Any]]) -> Array:
        return Chain(Model(arm, effects), "wire").run(PHI, STAMP)[0][STAMP > 5.0]

    empty, always = swung(0.0), swung(mass)
    soon, hardly = swung(mass, payload_from=0.01), swung(mass, payload_until=0.02)
    for got, wanted in ((soon, always), (hardly, empty)):
        assert np.std(got - wanted) < 0.02 * np.std(always - empty)


MOMENTS = st.floats(0.0, 20.0) | st.just(0.0) | st.just(1e6)


@given(
    st.lists(st.fixed_dictionaries(dict.fromkeys(("from", "until", "grown", "from_2"), MOMENTS)), max_size=3)
)
def test_columns_side_by_side_act_as_each_alone(columns: list[dict[str, float]]) -> None:
    columns = [*columns, *columns[-1:]]  # one is as the one before
    together = share(
        STAMP, {n: np.array([c[n] for c in columns]) for n in (columns or [{}])[0]}, len(columns)
    )
    for k, column in enumerate(columns):
        assert np.array_equal(together[:, k], share(STAMP, column, 1)[:, 0])
        ramp = np.clip((STAMP - column["from"]) / RISE + 0.5, 0.0, 1.0)
        if (
            column["from"] > 0.0
            and column["grown"] <= column["from"]
            and column["until"] == 1e6 == column["from_2"]
        ):
            assert together[:, k] == pytest.approx(ramp, abs=1e-12)


def test_how_much_acts_is_known_where_a_joint_stood_and_on_all_of_its_way() -> None:
    bent = effect("ratio_error")({"relative": np.array([0.02]), "from": np.array([5.0])})
    now, stood = (Seeing(stamp) for stamp in (STAMP, STAMP[:9]))
    first = [lasting.acting(bent, one) for one in (now, stood)]  # type: ignore[arg-type]
    again = [lasting.acting(bent, one) for one in (now, stood, now)]  # type: ignore[arg-type]
    assert again[0] is first[0] is again[2]
    assert again[1] is first[1]
    assert len(first[0]) == len(STAMP)
    assert len(first[1]) == 9
