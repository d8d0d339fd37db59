"""Names and units of effects: model files, recordings and other programs rely on them as they are here."""

from __future__ import annotations

import pytest

from trunk_ros.effects import imitated, registry
from trunk_ros.errors import ModelError
from trunk_ros.model import Model, declared_parameters, load_model

# effect: stage, regime, {parameter: unit}, names of the shared ones
TABLE: dict[str, tuple[str, str, dict[str, str], set[str]]] = {
    "ratio_error": ("wire", "posture", {"relative": "1"}, set()),
    "transmission_ripple": (
        "wire", "posture", {"amplitude": "rad", "cycles_per_rev": "1", "phase": "rad"}, set(),
    ),
    "joint_coupling": ("wire", "posture", {"gain": "1"}, set()),
    "thermal_drift": ("wire", "time", {"amplitude": "rad", "time_constant": "s", "rate": "rad/s"}, set()),
    "wire_slip": ("wire", "time", {"onset": "s", "step": "rad"}, set()),
    "backlash": ("wire", "reversal", {"half_width": "rad"}, set()),
    "narrow_band": ("wire", "reversal", {"less": "1"}, set()),
    "tension_error": ("wire", "reversal", {"factor": "1"}, {"factor"}),
    "load_dependent_friction": ("wire", "reversal", {"gain": "rad/(N*m)"}, set()),
    "stribeck_friction": ("wire", "low_speed", {"amplitude": "rad", "velocity": "rad/s"}, set()),
    "friction_wear": ("wire", "reversal", {"rate": "rad/s"}, set()),
    "friction_warming": ("wire", "reversal", {"fall": "rad", "time_constant": "s"}, set()),
    "presliding_hysteresis": ("wire", "reversal", {"width": "rad"}, set()),
    "load_elasticity": ("wire", "posture", {"compliance": "rad/(N*m)", "payload": "kg"}, {"payload"}),
    "wire_slack": (
        "wire", "posture", {"threshold": "N*m", "compliance": "rad/(N*m)", "payload": "kg"}, {"payload"},
    ),
    "wire_stiffening": (
        "wire", "posture", {"moment": "N*m", "compliance": "rad/(N*m)", "payload": "kg"}, {"payload"},
    ),
    "viscoelastic_creep": ("wire", "hold", {"gain": "1", "time_constant": "s"}, {"time_constant"}),
    "viscous_lag": ("wire", "high_speed", {"time_constant": "s"}, set()),
    "link_resonance": ("wire", "high_speed", {"frequency": "Hz", "damping": "1"}, set()),
    "hard_stop": ("wire", "posture", {"upper": "rad", "lower": "rad"}, set()),
    "sensor_delay": ("wire", "high_speed", {"delay": "s"}, {"delay"}),
    "zero_offset": ("wire", "always", {"offset": "rad"}, set()),
    "wrap_friction": ("wire", "reversal", {"gain": "1"}, set()),
    "posture_ratio": ("wire", "posture", {"gain": "1/rad"}, set()),
    "servo_offset": ("servo", "always", {"offset": "rad"}, set()),
    "servo_delay": ("servo", "high_speed", {"delay": "s"}, {"delay"}),
    "servo_bandwidth": ("servo", "high_speed", {"relative": "1"}, {"relative"}),
    "speed_feedforward": ("servo", "high_speed", {"share": "1"}, {"share"}),
    "velocity_loop": ("servo", "high_speed", {"relative": "1"}, {"relative"}),
    "velocity_saturation": ("servo", "high_speed", {"v_max": "rad/s"}, {"v_max"}),
    "uneven_speed": ("servo", "high_speed", {"excess": "1"}, set()),
    "setpoint_ceiling": ("servo", "posture", {"upper": "rad"}, set()),
    "setpoint_floor": ("servo", "posture", {"lower": "rad"}, set()),
    "setpoint_rate": ("servo", "high_speed", {"rate": "rad/s"}, set()),
    "acceleration_limit": ("servo", "high_speed", {"acceleration": "rad/s^2"}, {"acceleration"}),
    "setpoint_profile": ("servo", "high_speed", {"acceleration": "rad/s^2"}, {"acceleration"}),
    "motor_friction": ("servo", "reversal", {"friction": "rad"}, {"friction"}),
    "integral_action": ("servo", "high_speed", {"ki": "1/s^2"}, {"ki"}),
    "speed_integral": ("servo", "high_speed", {"rate": "1/s"}, {"rate"}),
    "load_droop": ("servo", "posture", {"gain": "rad/(N*m)"}, {"gain"}),
    "cogging": (
        "servo", "posture", {"amplitude": "rad", "cycles_per_rev": "1"}, {"amplitude", "cycles_per_rev"},
    ),
    "link_length_error": ("arm", "always", {"length_error": "m"}, set()),
    "base_tilt": ("arm", "always", {"angle": "rad"}, {"angle"}),
}  # fmt: skip
ORDER = (
    "ratio_error", "transmission_ripple", "joint_coupling", "thermal_drift", "wire_slip", "backlash",
    "load_elasticity", "viscoelastic_creep", "viscous_lag", "link_resonance", "hard_stop", "sensor_delay",
    "zero_offset",
)  # fmt: skip


@pytest.mark.parametrize("name", TABLE)
def test_stage_regime_and_parameters_are_those_that_others_rely_on(name: str) -> None:
    kind = registry()[name]
    stage, regime, units, shared = TABLE[name]
    assert (kind.stage, kind.regime) == (stage, regime)
    ours = {p.name: p for p in kind.parameters}
    assert {key: ours[key].unit for key in units} == units
    assert {key for key in units if ours[key].shared} == shared


@pytest.mark.parametrize("name", TABLE)
def test_every_parameter_is_declared_for_the_nodes(name: str) -> None:
    declared = {d.name: d for d in declared_parameters()}
    for parameter in registry()[name].parameters:
        declaration = declared[f"effects.{name}.{parameter.name}"]
        assert (declaration.unit, declaration.bounds) == (parameter.unit, parameter.bounds)
        assert isinstance(declaration.default, float) == parameter.shared


def test_a_coupling_names_its_source() -> None:
    assert registry()["joint_coupling"].texts[0] == "source"


def test_the_wire_acts_in_the_order_that_others_rely_on() -> None:
    places = [registry()[name].place for name in ORDER]
    assert places == sorted(places)
    assert len(set(places)) == len(places)


def test_a_late_sensor_is_never_compensated() -> None:
    assert not registry()["sensor_delay"].compensable


def test_what_a_clock_does_looks_like_effects_and_like_what_has_no_name_last() -> None:
    assert imitated("skew") == ("thermal_drift", "friction_warming", "friction_wear", "sensor_delay")
    assert imitated("repeats")[-1] == "unknown"


@pytest.mark.parametrize("name", [name for name, kind in registry().items() if len(kind.forms) > 1])
def test_a_form_that_an_effect_does_not_have_is_said(name: str) -> None:
    lead = registry()[name].parameters[0]
    given = {f"effects.{name}.form": "square", f"effects.{name}.{lead.name}": lead.typical}
    with pytest.raises(ModelError, match="has no form 'square'"):
        Model.from_parameters(load_model("trunk").parameters() | given)
