"""A link that swings on its wire's spring swings in MuJoCo as well: as fast, and for as long."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from test.export.arms import SDF, model_of, pair
from trunk_ros.bodies.found import Bodies, Value
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.export.mjcf import MjcfWriter
from trunk_ros.export.run import export
from trunk_ros.export.sheet import Sheet
from trunk_ros.model import Model

mujoco = pytest.importorskip("mujoco")

KP, KV, STEP = 200.0, 8.0, 1e-3
SOFT, RATIO = 0.02, 0.08
MJCF = f"""<mujoco><compiler angle="radian"/>
<option timestep="{STEP}" integrator="implicitfast" gravity="0 0 0"/>
<worldbody><body name="upper" pos="0 0 0.1"><joint name="shoulder" axis="1 0 0" armature="0.01"/>
<geom type="sphere" size="0.001" pos="0 0 0.1" mass="0.8" contype="0"/>
<body name="lower" pos="0 0 0.2"><joint name="elbow" axis="1 0 0"/>
<geom type="sphere" size="0.001" pos="0 0 0.075" mass="0.5" contype="0"/>
<site name="tip" pos="0 0 0.15"/></body></body></worldbody>
<actuator><position joint="shoulder" kp="{KP}" kv="{KV}"/>
<position joint="elbow" kp="4000" kv="40"/></actuator>
</mujoco>"""


def arm_with(effects: dict[str, Any]) -> Model:
    """Links with masses at their middles, without weight."""
    plain = model_of(effects)
    return replace(plain, arm=replace(plain.arm, link_mass=np.array([0.8, 0.5]), gravity=0.0))


SWINGS = {"load_elasticity": {"compliance": pair(SOFT), "form": "links", "damping": pair(RATIO, RATIO)}}
SERVO = {"load_elasticity": {"compliance": pair(1.0 / KP)}}
"""What the simulator's own loop gives way."""


def exported(tmp_path: Path, more: dict[str, Any] | None = None, bodies: Bodies | None = None) -> Sheet:
    (tmp_path / "arm.xml").write_text(MJCF)
    model = arm_with({**SWINGS, **(more or {})})
    return export(model, "mjcf", tmp_path / "arm.xml", arm_with(SERVO), bodies)


def released(text: str) -> Array:
    """The shoulder's angle (n,) rad after its command went from 50 mrad to 0."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[0] = data.ctrl[0] = 0.05
    data.act[:] = 0.05
    mujoco.mj_step(model, data, 500)
    data.ctrl[0], out = 0.0, np.empty(1500)
    for k in range(len(out)):
        mujoco.mj_step(model, data)
        out[k] = data.qpos[0]
    return out


def swing_of(angle: Array) -> tuple[float, float]:
    """Frequency [Hz] and damping ratio of what swings about 0, every STEP."""
    up = np.flatnonzero((angle[:-1] < 0.0) & (angle[1:] >= 0.0))[:5]
    tops = [angle[begin:end].max() for begin, end in pairwise(up)]
    falls = -float(np.diff(np.log(tops)).mean())
    return 1.0 / (STEP * float(np.diff(up).mean())), falls / float(np.hypot(falls, 2.0 * np.pi))


def test_a_link_that_is_released_swings_as_the_model_says(tmp_path: Path) -> None:
    hertz, ratio = swing_of(released(exported(tmp_path).text))
    stamp = np.arange(0.0, 2.0, STEP)
    wire = np.where(stamp < 0.5, 0.05, 0.0)[:, None] * [1.0, 0.0]
    meant = swing_of(Chain(arm_with(SWINGS), "wire").run(wire, stamp)[0][501:, 0])
    assert hertz == pytest.approx(meant[0], rel=0.03)
    assert ratio == pytest.approx(meant[1], rel=0.2)
    assert meant[1] == pytest.approx(RATIO, rel=0.02)


def test_a_ramp_is_followed_as_late_as_before(tmp_path: Path) -> None:
    sheet, ramp = exported(tmp_path), 0.2
    model = mujoco.MjModel.from_xml_string(sheet.text)
    data = mujoco.MjData(model)
    for k in range(2500):
        data.ctrl[0] = ramp * k * STEP
        mujoco.mj_step(model, data)
    assert ramp * data.time - data.qpos[0] == pytest.approx(ramp * KV / KP, rel=0.05)
    (tmp_path / "new.xml").write_text(sheet.text)
    assert MjcfWriter(arm_with({}), tmp_path / "new.xml").lags()[0] == pytest.approx(KV / KP)
    assert any("begin with its actuator's `act` at the command" in remark for remark in sheet.remarks)


def test_the_rotor_lies_before_the_spring(tmp_path: Path) -> None:
    rotor = {"armature": Value(0.02, 1e-3, "kg m^2"), "friction": Value(0.1, 1e-3, "N m")}
    sheet = exported(tmp_path, bodies=Bodies(("run",), {"shoulder": rotor, "elbow": rotor}, "elbow"))
    model = mujoco.MjModel.from_xml_string(sheet.text)
    assert model.dof_armature == pytest.approx([0.0, 0.02])
    assert model.dof_frictionloss == pytest.approx([0.0, 0.1])
    assert any(remark.startswith("shoulder: armature 0.02 kg m^2: not written") for remark in sheet.remarks)


def test_a_link_that_friction_holds_sticks_and_slips_as_the_model_says(tmp_path: Path) -> None:
    more = {"backlash": {"half_width": pair(4e-3)}}
    held = {"load_elasticity": {**SWINGS["load_elasticity"], "form": "held"}}
    sheet = exported(tmp_path, {**more, **held})
    assert not any("would hold it" in remark for remark in sheet.remarks)
    stamp = np.arange(0.0, 6.0, STEP)
    wire = 0.05 * np.sin(2.0 * np.pi * 0.4 * stamp)[:, None] * [1.0, 0.0]
    model = mujoco.MjModel.from_xml_string(sheet.text)
    data, shown = mujoco.MjData(model), np.empty(len(stamp))
    for k in range(len(stamp)):
        data.ctrl[0] = wire[k, 0]
        mujoco.mj_step(model, data)
        shown[k] = data.qpos[0]
    lag = STEP * KP / KV
    late = lfilter([lag], [1.0, lag - 1.0], wire, axis=0)
    meant, light = (
        Chain(arm_with({**more, **effects}), "wire").run(late, stamp)[0][:, 0] for effects in (held, {})
    )
    assert np.std(shown - meant) < 0.3 * np.std(shown - light)


def test_what_would_hold_the_link_or_is_too_quick_is_said(tmp_path: Path) -> None:
    held = exported(tmp_path, {"backlash": {"half_width": pair(4e-3)}})
    assert any("its swing is not written: friction would hold it" in remark for remark in held.remarks)
    (tmp_path / "arm.xml").write_text(MJCF.replace(f'timestep="{STEP}"', 'timestep="0.02"'))
    quick = export(arm_with(SWINGS), "mjcf", tmp_path / "arm.xml", arm_with(SERVO))
    assert any("too quick for the time step" in remark for remark in quick.remarks)
    (tmp_path / "arm.xml").write_text(MJCF.replace('mass="0.8"', 'mass="1.8"'))
    heavy = export(arm_with(SWINGS), "mjcf", tmp_path / "arm.xml", arm_with(SERVO))
    assert any("with the model's masses: the file has others" in remark for remark in heavy.remarks)


def test_sdf_leaves_the_swing_to_the_layer(tmp_path: Path) -> None:
    (tmp_path / "arm.sdf").write_text(SDF)
    sheet = export(arm_with(SWINGS), "sdf", tmp_path / "arm.sdf")
    assert set(sheet.layer.effects) == {"load_elasticity"}
