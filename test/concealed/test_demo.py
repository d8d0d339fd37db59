"""Claims about the demo: the live arm is the concealed plant, and the story holds from end to end."""

from __future__ import annotations

import importlib.util
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from test.concealed.demo import OWN, SEED, outcome
from test.concealed.demo_runs import ROOT
from test.concealed.hide import hide
from test.concealed.live_arm import LiveArm
from test.concealed.nominal import RATIO, Array
from test.concealed.plant import run
from test.concealed.trajectory import draw_reference

needs_ros = pytest.mark.skipif(
    importlib.util.find_spec("rclpy") is None, reason="ROS 2 is not installed here"
)
COMMAND = [sys.executable, "-m", "test.concealed.demo"]


@pytest.fixture(scope="module")
def setpoints() -> Array:
    t = np.arange(600, dtype=np.float64) * 0.01
    reference = draw_reference(np.random.default_rng(0), "mixed", t)
    moved: Array = reference / RATIO * np.minimum(t, 1.0)[:, None] ** 2
    return moved


@pytest.mark.parametrize(
    "effect",
    ["backlash", "presliding_hysteresis", "joint_coupling", "load_elasticity", "viscoelastic_creep",
     "link_resonance", "sensor_delay", "servo_delay", "cogging", "friction_wear"],
)  # fmt: skip
def test_the_live_arm_moves_tick_by_tick_as_the_plant_does_at_once(effect: str, setpoints: Array) -> None:
    hidden = hide(4, [effect])
    arm, phi, theta = LiveArm(hidden), [], []
    for setpoint in setpoints:
        sample = arm.sample()
        phi.append(sample.phi)
        theta.append(sample.shown)
        arm.tick(setpoint)
    whole = run(hidden, setpoints)
    np.testing.assert_allclose(phi, whole.phi[::5], atol=1e-12)
    np.testing.assert_allclose(theta, whole.theta[::5], atol=1e-6)


def test_the_usual_arm_hides_several_effects_and_always_the_same() -> None:
    hidden, again = hide(SEED), hide(SEED)
    assert len({h.effect for h in hidden}) == 3
    assert [h.told() for h in hidden] == [h.told() for h in again]


def test_an_effect_that_there_is_not_is_refused_in_one_line() -> None:
    done = subprocess.run([*COMMAND, "--effects", "magic"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.startswith("demo: no effect magic")
    assert len(done.stderr.splitlines()) == 1


@needs_ros
@pytest.mark.timeout(600)
def test_what_is_hidden_is_named_and_told_only_after_the_verdict(tmp_path: Path) -> None:
    asked = ["--effects", "zero_offset", "--seed", "3", "--seconds", "12", "--output", str(tmp_path)]
    done = subprocess.run([*COMMAND, *asked], cwd=ROOT, capture_output=True, text=True, timeout=560)
    assert done.returncode == 0, done.stdout + done.stderr
    assert 0 < done.stdout.index("Verdict:") < done.stdout.index("What was hidden")
    assert (tmp_path / "demo.png").read_bytes().startswith(b"\x89PNG")
    assert str(tmp_path / "diagnosis" / "model.yaml") in (tmp_path / "diagnosis" / "report.html").read_text()
    assert (tmp_path / "diagnosis" / "model.yaml").exists()
    found = json.loads((tmp_path / "diagnosis" / "diagnosis.json").read_text())["findings"]
    assert "zero_offset" in [name for one in found for name in (one["effect"], *one["equivalents"])]
    assert all(any(path.match(own) for own in OWN) for path in tmp_path.iterdir())


@needs_ros
def test_interrupted_it_leaves_no_process_behind(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [*COMMAND, "--output", str(tmp_path)], cwd=ROOT, start_new_session=True, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    end = time.monotonic() + 60
    while not list(tmp_path.glob("run_1/*.mcap")):
        assert time.monotonic() < end
        assert process.poll() is None
        time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=40)
    assert process.returncode == 130
    assert error.splitlines() == ["demo: ended by hand"]
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)


@pytest.mark.parametrize(
    ("found", "equivalents", "says"),
    [
        ("backlash", [], "Decided: backlash, not stribeck_friction"),
        ("stribeck_friction", ["cogging"], "Decided: stribeck_friction, not backlash"),
        ("backlash", ["stribeck_friction"], "Not decided: backlash or stribeck_friction"),
        ("cogging", [], "Decided: neither backlash nor stribeck_friction"),
    ],
)
def test_it_says_what_the_proposed_motion_has_decided(found: str, equivalents: list[str], says: str) -> None:
    findings = [{"effect": found, "equivalents": equivalents}]
    assert outcome(["backlash", "stribeck_friction"], findings) == says
