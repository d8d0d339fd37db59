"""Joints that a hand guides turn their motors through the play of their wires: they are told as such and not
diagnosed, and what makes a joint late or early is not taken for it.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from test.diagnosis.arms import NOISE, SHORT, diagnose, of_the_wires, on, recorded, reshaped
from trunk_ros.data.mix_ups import mix_ups
from trunk_ros.data.put_right import put_right
from trunk_ros.effects.wire.play import SharpPlay
from trunk_ros.model import Model
from trunk_ros.recording.recording import Recording

NAMES = SHORT.arm.joints
PLAY = 5e-4
SECONDS = 40.0


def made(effects: dict[str, dict[str, Any]] | None = None, seed: int = 0, size: float = 1.0) -> Recording:
    return of_the_wires(recorded(effects, SECONDS, seed, size=size, nominal=SHORT))


def by_hand(recording: Recording, joints: tuple[int, ...], half_width: float, seed: int = 7) -> Recording:
    """The recording with joints that go as their motors went, and motors that follow them through a play."""
    motors = recording.series["gearbox_states"].position.copy()
    angles, ratio = recording.series["joint_states"].position.copy(), SHORT.arm.ratio
    rng = np.random.default_rng(seed)
    for j in joints:
        led = ratio[j] * motors[:, [j]]
        followed = SharpPlay().run(led, np.array([[half_width]]), led[0])[0]
        motors[:, j] = followed[:, 0] / ratio[j]
        angles[:, j] = led[:, 0] + rng.normal(0.0, NOISE, len(led))
    guided = reshaped(recording, "gearbox_states", position=motors, velocity=None)
    return reshaped(guided, "joint_states", position=angles, velocity=None)


def ahead(recording: Recording, seconds: float) -> Recording:
    return reshaped(
        recording, "joint_states", stamp=recording.series["joint_states"].stamp - seconds, velocity=None
    )


@pytest.mark.parametrize("joints", [(0, 1, 2), (1,)])
@pytest.mark.parametrize("seed", range(3))
def test_joints_that_lead_their_motors_are_named(joints: tuple[int, ...], seed: int) -> None:
    (told,) = mix_ups(by_hand(made(seed=seed), joints, PLAY), SHORT)
    assert (told.kind, told.stage, told.certain) == ("guided", "wire", True)
    assert told.joints == tuple(NAMES[j] for j in joints)
    assert told.statement.startswith(f"guided by hand? joint_states of {', '.join(told.joints)} ")
    (said,) = re.findall(r"through a play of ± ([\d.]+) mrad", told.statement)
    assert float(said) == pytest.approx(1e3 * PLAY, rel=0.05)


@pytest.mark.parametrize("late", [-0.02, 0.004])
def test_a_clock_beside_it_hides_it_not(late: float) -> None:
    (told,) = mix_ups(ahead(by_hand(made(), (0, 1, 2), PLAY), late), SHORT)
    assert (told.kind, told.joints) == ("guided", NAMES)


@pytest.mark.parametrize("half_width", [0.0, NOISE / 2])
def test_what_is_no_more_than_noise_is_not_said(half_width: float) -> None:
    assert mix_ups(by_hand(made(), (0, 1, 2), half_width), SHORT) == []


@pytest.mark.parametrize(
    "effects",
    [
        {},
        {"backlash": {"half_width": np.full(3, 2e-3)}},
        {"backlash": {"half_width": np.full(3, 3e-2)}},
        {"viscous_lag": {"time_constant": np.full(3, 0.1)}},
        {"stribeck_friction": {"extra_half_width": np.full(3, 3e-3), "velocity": np.full(3, 0.05)}},
        {"link_resonance": {"frequency": np.full(3, 1.5), "damping": np.full(3, 0.05)}},
        {"viscoelastic_creep": {"gain": np.full(3, 0.05), "time_constant": 3.0}},
        {"presliding_hysteresis": {"half_width": np.full(3, 1e-3), "radius": np.full(3, 2e-3)}},
        {"joint_coupling": {"gain": on(3, -0.3, 3), "source": ["", "", NAMES[1]]},
         "backlash": {"half_width": on(2, 5e-3, 3)}},
    ],
    ids=lambda effects: "+".join(effects),
)  # fmt: skip
@pytest.mark.parametrize("by", [0.0, 0.01])
def test_what_physics_or_an_early_clock_does_is_not_a_hand(effects: dict[str, Any], by: float) -> None:
    for seed in range(2):
        assert mix_ups(ahead(made(effects, seed), by), SHORT) == []


@pytest.mark.parametrize("late", [0.003, 0.03])
def test_a_lead_by_time_at_one_speed_is_none_by_way(late: float) -> None:
    """At one speed to and fro the two look alike."""
    sound = made()
    stamp = sound.series["joint_states"].stamp
    phase = stamp[:, None] / [5.0, 4.0, 3.0]
    there_and_back = 0.3 * np.abs(2.0 * (phase % 1.0) - 1.0)
    shown = SHORT.arm.ratio * there_and_back
    noise = np.random.default_rng(1).normal(0.0, NOISE, shown.shape)
    motors = reshaped(sound, "gearbox_states", position=there_and_back, velocity=None)
    steady = reshaped(motors, "joint_states", position=shown + noise, velocity=None)
    assert mix_ups(ahead(steady, late), SHORT) == []


def test_a_lead_that_grows_faster_than_speed_is_none_by_way() -> None:
    sound = made()
    motor = sound.series["gearbox_states"].position * SHORT.arm.ratio
    speed = np.gradient(motor, sound.series["gearbox_states"].stamp, axis=0)
    for power in (0.5, 1.5, 3.0):
        off = 3e-3 * np.sign(speed) * (np.abs(speed) / np.abs(speed).max()) ** power
        odd = reshaped(sound, "joint_states", position=sound.series["joint_states"].position + off)
        assert mix_ups(odd, SHORT) == [], power


def test_a_guided_joint_hides_no_early_clock_of_the_others() -> None:
    """Joints without readings had counted as joints that do not agree."""
    (right,), _ = put_right([ahead(by_hand(made(), (1,), PLAY), 0.005)], SHORT)
    assert [(one.kind, one.joints) for one in right.observed] == [("early", (NAMES[0], NAMES[2]))]
    assert right.observed[0].value == pytest.approx(0.005, abs=5e-4)


def test_guided_joints_get_no_finding_and_the_others_are_judged() -> None:
    told = diagnose([by_hand(made(), (1,), PLAY)], SHORT)
    assert told.findings == []
    assert [(rest.stage, rest.joints) for rest in told.unexplained] == [("wire", [NAMES[1]])]
    assert "guided by hand?" in told.unexplained[0].statement
    assert set(told.stages["wire"]["joints"]) == {NAMES[0], NAMES[2]}
    assert [one["kind"] for one in told.quality["made"]["mix_ups"]] == ["guided"]


def test_an_arm_that_is_guided_is_unexplained_without_a_search() -> None:
    told = diagnose([by_hand(made(), (0, 1, 2), PLAY)], Model(SHORT.arm))
    assert told.verdict == "unexplained"
    assert told.findings == []
    assert not told.stages["wire"]["compared"]
