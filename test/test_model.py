"""The model on disk: what is written is read back, and what is wrong is said in one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from test.effects.example import CASES, arm_of, everything, model_of
from trunk_ros.effects import effect
from trunk_ros.errors import ModelError
from trunk_ros.model import Model, declared_parameters, load_model, save_model

CONFIG = Path(__file__).parent.parent / "config"


def same(one: Model, other: Model) -> bool:
    """Whether two models have the same parameters."""
    return one.parameters() == other.parameters()


@pytest.mark.parametrize(("name", "form"), CASES)
def test_a_model_with_an_effect_is_read_as_it_was_written(name: str, form: str, tmp_path: Path) -> None:
    model = model_of(name, form)
    save_model(model, tmp_path / "model.yaml")
    again = load_model(tmp_path / "model.yaml")
    assert same(again, model)
    assert again.hash() == model.hash()
    for key, value in model.effects[name].items():
        assert np.array_equal(again.effects[name][key], value), key


def test_a_model_with_everything_is_read_as_it_was_written(tmp_path: Path) -> None:
    model = everything()
    save_model(model, tmp_path / "model.yaml")
    assert same(load_model(tmp_path / "model.yaml"), model)


@pytest.mark.parametrize("name", ["trunk", "direct"])
def test_a_model_of_config_is_found_by_name_and_by_file(name: str) -> None:
    assert same(load_model(name), load_model(CONFIG / f"{name}.yaml"))


def test_values_in_place_of_the_wires_formula_are_kept(tmp_path: Path) -> None:
    flat = load_model("trunk").parameters()
    flat |= {"wire.dead_band": [1e-9 + 3.66e-4] * 5, "wire.compliance": [0.1], "wire.ratio": [-0.5]}
    save_model(Model.from_parameters(flat), tmp_path / "model.yaml")
    arm = load_model(tmp_path / "model.yaml").arm
    assert arm.dead_band.tolist() == [1e-9 + 3.66e-4] * 5
    assert (arm.compliance[0], arm.ratio[0]) == (0.1, -0.5)


def test_one_value_stands_for_all_joints() -> None:
    flat = {"arm.joints": ["a", "b"], "wire.ratio": [0.5], "effects.backlash.half_width": [1e-3]}
    model = Model.from_parameters(flat)
    assert model.arm.ratio.tolist() == [0.5, 0.5]
    assert model.effects["backlash"]["half_width"].tolist() == [1e-3, 1e-3]


def test_the_direct_model_takes_the_recordings_joints() -> None:
    model = load_model("direct")
    assert model.any_joints
    bound = model.for_joints(("q4", "q5", "q6"))
    assert (bound.arm.joints, bound.arm.ratio.tolist()) == (("q4", "q5", "q6"), [1.0, 1.0, 1.0])


def test_a_model_for_any_joints_takes_its_effects_along() -> None:
    flat = {"arm.joints": ["*"], "effects.backlash.half_width": [1e-3], "arm.link_length": [0.1]}
    bound = Model.from_parameters(flat).for_joints(("a", "b"))
    assert bound.effects["backlash"]["half_width"].tolist() == [1e-3, 1e-3]
    assert bound.arm.link_length.tolist() == [0.1, 0.1]


def test_the_declared_defaults_are_a_model_without_effects() -> None:
    model = Model.from_parameters({d.name: d.default for d in declared_parameters()})
    assert model.any_joints
    assert model.effects == {}


def test_the_payload_found_is_added_to_the_nominal_one() -> None:
    arm = arm_of(2)
    model = Model(arm, {"load_elasticity": {"payload": 0.2, "compliance": np.full(2, 0.03)}})
    assert model.loaded_arm().payload == pytest.approx(0.2)


def test_the_hash_changes_with_any_parameter() -> None:
    models = [*(model_of(name, form) for name, form in CASES), Model(arm_of(5)), Model(arm_of(4))]
    assert len({model.hash() for model in models}) == len(models)


def test_an_effect_at_its_null_is_no_part_of_the_model() -> None:
    still = Model(arm_of(2), {"backlash": {"half_width": np.zeros(2)}})
    assert same(still, Model(arm_of(2)))
    assert still.hash() == Model(arm_of(2)).hash()


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "a misspelt name": (
        {"wire.ratoi": [1.0]},
        r"unknown parameter 'wire.ratoi': did you mean 'wire.ratio'\?",
    ),
    "a misspelt effect": (
        {"effects.backslash.half_width": [1.0]},
        "unknown effect 'backslash': did you mean 'backlash'",
    ),
    "too many values": ({"wire.ratio": [1.0, 2.0, 3.0]}, "wire.ratio has 3 values for 2 joints"),
    "too many effect values": (
        {"effects.backlash.half_width": [0.1] * 3},
        "half_width has 3 values for 2 joints",
    ),
    "a list for a shared value": ({"effects.sensor_delay.delay": [0.1, 0.2]}, "delay has 2 values: give 1"),
    "a negative play": (
        {"effects.backlash.half_width": [-0.1]},
        r"half_width = \[-0.1\]: must be 0 ... 1000 rad",
    ),
    "a ratio of zero": ({"wire.ratio": [0.0, 1.0]}, "wire.ratio of a is 0"),
    "a joint that is not there": (
        {"effects.joint_coupling.gain": [0.0, 0.1], "effects.joint_coupling.source": ["", "c"]},
        "source of b is 'c': choose from a",
    ),
    "a joint that drags itself": (
        {"effects.joint_coupling.gain": [0.1, 0.0], "effects.joint_coupling.source": ["a", ""]},
        "source of a is 'a': choose from b",
    ),
    "a gain without a source": ({"effects.joint_coupling.gain": [0.1]}, "source of a is '': choose from b"),
    "too many words": (
        {"effects.joint_coupling.gain": [0.0, 0.1], "effects.joint_coupling.source": ["", "a", "b"]},
        "source has 3 words for 2 joints",
    ),
    "an unknown form": (
        {"effects.stribeck_friction.amplitude": [0.1], "effects.stribeck_friction.form": "square"},
        "has no form 'square': choose one of exponential, gaussian, hyperbolic",
    ),
    "a curve over nothing known": (
        {"effects.unknown.value_03": [0.1], "effects.unknown.high": [1.0], "effects.unknown.on": ["mood"]},
        "'mood': choose from position, speed, time, load, a, b",
    ),
    "a curve without a range": (
        {"effects.unknown.value_03": [0.1], "effects.unknown.on": ["time"]},
        "low must be below high",
    ),
    "an effect twice": (
        {"effects.wire_slack.compliance": [0.1], "effects.load_elasticity.compliance": [0.1]},
        "effects.wire_slack includes effects.load_elasticity",
    ),
    "a word for a number": ({"servo.kp": "fast"}, "servo.kp = 'fast': must be a number"),
    "a truth for a number": ({"servo.kp": True}, "servo.kp = True: must be a number"),
    "a number for a word": ({"effects.hard_stop.form": 3}, r"form = \[3\]: must be words"),
    "numbers for names": ({"arm.joints": [1, 2]}, r"arm.joints = \[1, 2\]: must be words"),
    "one name for a list": ({"arm.joints": "a"}, "arm.joints = 'a': must be words"),
    "the same name twice": ({"arm.joints": ["a", "a"]}, "must be different names"),
    "an empty name": ({"arm.joints": ["a", ""]}, "must be different names"),
    "no names": ({"arm.joints": []}, "must be different names"),
    "not a number": ({"servo.kp": float("nan")}, "servo.kp = .nan.: must be"),
    "an infinite one": ({"wire.ratio": [float("inf")]}, "must be"),
    "half a list": ({"wire.ratio": [1.0, float("nan")]}, "every value must be a finite number"),
    "a servo without gain": ({"servo.kp": 0.0}, "must be 1e-15"),
    "limits the wrong way round": (
        {"arm.lower": [0.5], "arm.upper": [0.1]},
        "arm.lower of a is above its arm.upper",
    ),
    "half a formula": (
        {"wire.shaft_radius": 0.01},
        "the wire's formula wants wire.cylinder_radius, wire.modulus",
    ),
    "a wire without stiffness": ({"wire.modulus": 0.0}, "wire.modulus = .0.0.: must be"),
    "a table in a list": ({"wire.ratio": [[1.0, 2.0]]}, "must be a number, or one per joint"),
    "a table for a number": ({"servo.kp": {"a": 1}}, "unknown parameter 'servo.kp.a'"),
}


def write(path: Path, flat: dict[str, Any]) -> Path:
    """A model file of flat parameters."""
    path.write_text(yaml.safe_dump({"/**": {"ros__parameters": {"arm.joints": ["a", "b"], **flat}}}))
    return path


@pytest.mark.parametrize("what", BAD)
def test_what_is_wrong_is_said_in_one_line_with_the_file(what: str, tmp_path: Path) -> None:
    flat, message = BAD[what]
    path = write(tmp_path / "model.yaml", flat)
    with pytest.raises(ModelError, match=message) as error:
        load_model(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not a ROS 2 parameter file"),
        ("- 1\n- 2", "not a ROS 2 parameter file"),
        ("a: 1", "not a ROS 2 parameter file"),
        ("/**: {ros__parameters: 3}", "not a ROS 2 parameter file"),
        ("/**:\n\t- [", "is not YAML"),
        ("/**: {ros__parameters: {arm: 2001-99-99}}", "is not YAML"),
        ("[" * 3000, "is not YAML"),
        ("&a {b: *a}", "refers to its own parts"),
        ("/**: {ros__parameters: &a {b: *a}}", "refers to its own parts"),
        ("\x00", "is not YAML"),
    ],
)
def test_a_file_that_is_no_model_is_called_so(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "model.yaml"
    path.write_text(text)
    with pytest.raises(ModelError, match=message) as error:
        load_model(path)
    assert "\n" not in str(error.value)


def test_a_missing_file_and_an_unknown_name_are_told_apart(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"cannot read the model .*gone\.yaml: No such file"):
        load_model(tmp_path / "gone.yaml")
    with pytest.raises(ModelError, match=r"no model 'trnk': give a file or one of direct, .*trunk"):
        load_model("trnk")
    with pytest.raises(ModelError, match=r"is a folder: give the file, such as .*model\.yaml"):
        load_model(tmp_path)


def test_bytes_that_are_no_text_are_no_model(tmp_path: Path) -> None:
    (tmp_path / "model.yaml").write_bytes(b"\xff\xfe\x00\xd8")
    with pytest.raises(ModelError):
        load_model(tmp_path / "model.yaml")


def test_a_wire_may_go_slack_on_one_joint_and_be_elastic_on_the_others(tmp_path: Path) -> None:
    flat = {
        "effects.wire_slack.compliance": [0.1, 0.0],
        "effects.wire_slack.threshold": [0.2, effect("wire_slack").parameter("threshold").null],
        "effects.load_elasticity.compliance": [0.0, 0.1],
    }
    model = load_model(write(tmp_path / "model.yaml", flat))
    assert {"wire_slack", "load_elasticity"} <= set(model.effects)


def test_simulated_time_beside_the_model_is_no_error(tmp_path: Path) -> None:
    assert load_model(write(tmp_path / "model.yaml", {"use_sim_time": True})).arm.joints == ("a", "b")


names = st.sampled_from([d.name for d in declared_parameters()])
scalars = st.one_of(st.floats(), st.integers(), st.text(max_size=4), st.booleans(), st.none())
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(flat=st.dictionaries(names, values, max_size=6))
def test_any_values_give_a_model_or_one_line(flat: dict[str, Any], tmp_path: Path) -> None:
    path = write(tmp_path / "model.yaml", flat)
    error = error_of(path)
    assert len(error.splitlines()) <= 1
    if not error:
        model = load_model(path)
        assert same(Model.from_parameters(model.parameters()), model)


def error_of(path: Path) -> str:
    """What is wrong with a model file; empty where nothing is."""
    try:
        load_model(path)
    except ModelError as error:
        return str(error)
    return ""


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    content=st.binary(max_size=60)
    | st.text(alphabet="/*:{}[]&!-<>\n\t ros__parameters\"'|", max_size=60).map(str.encode)
)
def test_any_bytes_give_one_line(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "model.yaml").write_bytes(content)
    with pytest.raises(ModelError) as error:
        load_model(tmp_path / "model.yaml")
    assert len(str(error.value).splitlines()) == 1
