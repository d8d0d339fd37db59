"""Real recordings, where they lie beside the project: a model found on one run predicts others."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from trunk_ros.diagnosis import Diagnosis, diagnose
from trunk_ros.recording.importing.csv import read_csv
from trunk_ros.recording.recording import Recording
from trunk_ros.share import config_path
from trunk_ros.simulate import simulate

REAL = Path(__file__).parents[3] / "shared" / "real"
FOLDER = REAL / "dvrk-wrist"
LINEAR = {"exp1": (0.121, 0.122), "exp2": (0.099, 0.103), "exp4": (0.141, 0.074)}
"""rms [rad] of q5 and q6 under a linear map of all six commands, fitted on the first 70 % of train_random."""
QUASI_STATIC = {"sensor_delay", "viscous_lag", "stribeck_friction", "link_resonance"}

pytestmark = [
    pytest.mark.skipif(not FOLDER.is_dir(), reason="no real recordings here"),
    pytest.mark.timeout(600),
]


def read(name: str) -> Recording:
    return read_csv(FOLDER / f"{name}.csv", config_path("import/dvrk-wrist"))


@pytest.fixture(scope="module")
def result() -> Diagnosis:
    return diagnose([read("train_random")], model="direct", until="70%")


def rms(result: Diagnosis, name: str) -> np.ndarray:
    run = read(name)
    predicted = simulate(run, result.model).series["joint_states"]
    error = predicted.position - run.series["joint_states"].select(predicted.joints).position
    return np.sqrt(np.nanmean(error**2, axis=0))[[predicted.joints.index("q5"), predicted.joints.index("q6")]]


@pytest.mark.parametrize("name", sorted(LINEAR))
def test_the_model_found_predicts_the_wrist_better_than_a_linear_map(result: Diagnosis, name: str) -> None:
    assert np.all(rms(result, name) < LINEAR[name])


def test_the_cross_talk_of_q5_and_q6_is_named(result: Diagnosis) -> None:
    (coupling,) = [f for f in result.findings if f.effect == "joint_coupling"]
    assert {"q5", "q6"} <= set(coupling.joints)
    assert coupling.parameters["q5"]["source"]["value"] == "q6"
    assert coupling.parameters["q6"]["source"]["value"] == "q5"


def test_a_recording_that_stops_to_measure_shows_nothing_of_speed(result: Diagnosis) -> None:
    assert not QUASI_STATIC & {f.effect for f in result.findings}
    assert "high_speed" not in {f.regime for f in result.findings}


def diagnosed(folder: str, name: str, mapping: str) -> Diagnosis:
    run = read_csv(REAL / folder / f"{name}.csv", config_path(f"import/{mapping}"))
    return diagnose([run], model="direct")


def named(result: Diagnosis) -> set[str]:
    return {f.effect for f in result.findings}


def value(result: Diagnosis, effect: str, joint: str, parameter: str) -> tuple[float, float]:
    """Value and spread; what was not found is 0."""
    found = [f for f in result.findings if f.effect == effect]
    if not found:
        return 0.0, 0.0
    told = found[0].parameters[joint][parameter]
    return told["value"], told["std"]


def test_dead_zone_and_hysteresis_of_the_tendon_sheath_are_named() -> None:
    assert {"backlash", "presliding_hysteresis"} <= named(
        diagnosed("tendon-sheath", "test0224", "tendon-sheath")
    )


@pytest.mark.parametrize(
    ("name", "mapping"),
    [
        ("test0224", "tendon-sheath"),
        ("odd_test", "tendon-sheath"),
        ("ff", "tendon-sheath-feedforward"),
        ("aurora_ff", "tendon-sheath-feedforward"),
        *((f"sheath_{angle}deg", "tendon-sheath") for angle in ("000", "060", "120", "180", "240")),
    ],
)
def test_a_slow_swing_of_the_tendon_sheath_shows_a_dead_band_and_nothing_of_speed(
    name: str, mapping: str
) -> None:
    result = diagnosed("tendon-sheath", name, mapping)
    assert "backlash" in named(result)
    assert not QUASI_STATIC & named(result)


def test_a_bent_sheath_has_a_wider_dead_band_and_moves_its_end_less_than_a_straight_one() -> None:
    straight = diagnosed("tendon-sheath", "sheath_000deg", "tendon-sheath")
    run = read_csv(REAL / "tendon-sheath" / "sheath_180deg.csv", config_path("import/tendon-sheath"))
    bent = diagnose([run], model=straight.model)
    (before, std_before), (after, std_after) = (
        value(result, "backlash", "bend", "half_width") for result in (straight, bent)
    )
    assert after - before > 3.0 * np.hypot(std_before, std_after)
    shown = [result.model.predict(run).series["joint_states"].position for result in (straight, bent)]
    assert np.ptp(shown[1]) < 0.9 * np.ptp(shown[0])  # by its ratio, or by the rounding of its reversals


@pytest.mark.parametrize(
    "name", ["z-0.105_28", "z-0.105_33", "z-0.105_59", "z-0.205_20", "z-0.205_34", "z-0.205_57"]
)
def test_the_compliance_of_the_tip_is_that_of_a_straight_line_over_the_measured_force(name: str) -> None:
    result = diagnosed("tip-compliance", name, "tip-compliance")
    table = np.genfromtxt(REAL / "tip-compliance" / f"{name}.csv", delimiter=",", names=True)
    off = table["tip_optical_z_m"] - table["tip_encoder_z_m"]
    compliance, std = value(result, "load_elasticity", "tip_z", "compliance")
    assert compliance == pytest.approx(np.polyfit(table["force_z"], off, 1)[0], rel=0.02)
    assert 0.0 < std < 0.05 * compliance
    assert not QUASI_STATIC & named(result)


def test_the_flexible_arm_rings_as_it_swings_while_the_hub_stands() -> None:
    result = diagnosed("flexible-link", "flexarm_K1_6", "flexible-link")
    table = np.genfromtxt(REAL / "flexible-link" / "flexarm_K1_6.csv", delimiter=",", names=True)
    free = np.convolve(table["tip_deflection_m"], np.ones(51) / 51, "same")[3000:7200]
    ups = np.flatnonzero((free[:-1] < 0.0) & (free[1:] >= 0.0))
    seconds = (ups[-1] - ups[0]) / 1000.0
    counted = (len(ups) - 1) / seconds
    assert value(result, "link_resonance", "arm", "frequency")[0] == pytest.approx(counted, rel=0.08)
    assert value(result, "link_resonance", "arm", "damping")[0] < 0.03


def test_the_rigid_arm_does_not_ring() -> None:
    assert not named(diagnosed("flexible-link", "rigidarm_K1_6", "flexible-link"))
