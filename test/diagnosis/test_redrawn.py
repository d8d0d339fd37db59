"""A curve that is no linear one is drawn anew where it is judged, also where a whole step goes too far: it
had been judged as no curve at all, and whatever harm it did stayed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trunk_ros.data.align import servo_span
from trunk_ros.diagnosis.discrepancy.curves import Place, ends, redrawn, with_curve
from trunk_ros.diagnosis.first_look import first_look
from trunk_ros.diagnosis.hypothesis import Hypothesis
from trunk_ros.diagnosis.servos.nominal_servo import with_its_servo
from trunk_ros.diagnosis.stages.servo import ServoStage
from trunk_ros.effects.curve import KNOTS, VALUES
from trunk_ros.model import load_model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.servo_course import servo_course

JOINT = ("a",)
DIRECT = load_model("direct").for_joints(JOINT)


def made() -> Recording:
    """A bus servo that is asked elsewhere each second, read at 10 Hz with stamps that are 20 ms off."""
    rng, stamp = np.random.default_rng(3), np.arange(0.0, 28.0, 0.1)
    asked = np.repeat(rng.uniform(-0.38, 0.38, 30), 10)[: len(stamp), None]
    arm = replace(DIRECT.arm, kp=10.0, tau_v=0.06, v_max=2.9, delay=0.07, servo_stated=True)
    read = np.sort(np.clip(stamp + rng.uniform(-0.02, 0.02, len(stamp)), 0.0, stamp[-1]))
    went = servo_course(JointSeries(stamp, JOINT, asked), read, replace(DIRECT, arm=arm)).position
    went = went + 1e-3 * rng.normal(size=went.shape)
    both = {"setpoints": JointSeries(stamp, JOINT, asked), "gearbox_states": JointSeries(stamp, JOINT, went)}
    return Recording("made", 0, float(stamp[-1]), both)


def test_a_curve_is_drawn_anew_where_a_whole_step_goes_too_far() -> None:
    recording = made()
    model = with_its_servo(DIRECT, [recording])
    context = first_look(ServoStage([servo_span(recording, model)], model))
    place = Place("unknown_servo", "speed", *ends(context, 0, "speed"))
    before = with_curve(Hypothesis(), place, 0, np.linspace(-0.1, 0.1, KNOTS))
    after = redrawn(context, before, 0)
    assert any(after["unknown_servo"].own[0][p.name] for p in VALUES)
    left = [float(np.sum(context.whitened(one, 0) ** 2)) for one in (after, Hypothesis())]
    assert left[0] < 0.9 * left[1]
