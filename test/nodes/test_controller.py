"""The compensator's decisions, without a node: what goes out at each step, and what does not."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from test.nodes.graph import JOINTS, ROOT
from trunk_ros.model import load_model
from trunk_ros.nodes.control import slow_feedback
from trunk_ros.nodes.control.begin import Graph
from trunk_ros.nodes.control.controller import Controller
from trunk_ros.nodes.control.goal import State
from trunk_ros.nodes.control.parameters import Settings
from trunk_ros.nodes.graph.elapsed import SECOND
from trunk_ros.nodes.graph.joints import MessageError
from trunk_ros.trajectory import Trajectory, TrajectoryError

MODEL = load_model("trunk")
STEP = SECOND // 100
HEARD, NOBODY, LOST = Graph(), Graph(said=False), Graph(lost=True)
SETTINGS = Settings(5e-5, 100.0, 2.0, False, True, slow_feedback.Settings(0.0, 0.005, 0.05, 5e-4))


class Bench:
    """A controller, and what it said."""

    def __init__(self):
        self.said, self.over, self.now = [], [], 0
        self.controller = Controller(
            MODEL, SETTINGS, False, self.said.append, self.said.append, self.over.append
        )

    def stands(self, phi):
        angle = np.full(5, float(phi))
        self.controller.observation_of("gearbox")(self.now, State(angle, np.zeros(5)))

    def steps(self, number, graph=HEARD):
        out = []
        for _ in range(number):
            self.now += STEP
            out.append(self.controller.update(self.now, graph))
        return out

    def go(self, angle, seconds=1.0, graph=HEARD):
        path = Trajectory(tuple(JOINTS), np.array([seconds]), np.full((1, 5), angle))
        return self.controller.follow(path, self.now, None, graph)


@pytest.fixture
def bench():
    return Bench()


def test_what_decides_needs_no_ros():
    modules = ("control.controller", "control.begin", "arm.servo", "arm.wire", "bus", "graph.losses", "stop")
    code = "import sys; sys.modules['rclpy'] = None\n" + "\n".join(
        f"import trunk_ros.nodes.{module}" for module in modules
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)


def test_nothing_goes_out_before_it_is_known_where_the_arm_stands(bench):
    assert bench.steps(50) == [None] * 50
    assert bench.steps(50, NOBODY) == [None] * 50


def test_at_rest_the_setpoint_is_exactly_where_the_arm_was_found(bench):
    bench.stands(0.3)
    for command in bench.steps(100):
        assert (command.setpoint == 0.3).all()
        np.testing.assert_allclose(command.reference[0], 0.3 * MODEL.arm.ratio, atol=1e-12)
    assert not bench.controller.settled


def test_even_outside_of_the_limits_it_is_not_moved_before_it_is_asked(bench):
    bench.stands(0.8)
    assert all((command.setpoint == 0.8).all() for command in bench.steps(100))
    bench.go(0.0)
    moved = np.array([0.8, *(command.setpoint[0] for command in bench.steps(300))])
    assert np.abs(np.diff(moved)).max() <= MODEL.arm.v_max * 0.01 + 1e-9
    assert abs(moved[-1]) < 1e-2


def test_from_rest_a_trajectory_begins_without_a_jump_and_ends_where_it_should(bench):
    bench.stands(0.3)
    bench.steps(20)
    bench.go(-0.1, 2.0)
    commands = bench.steps(400)
    path = np.array([0.3, *(command.setpoint[0] for command in commands)])
    assert np.abs(np.diff(path)).max() <= MODEL.arm.v_max * 0.01 + 1e-9
    np.testing.assert_allclose(commands[-1].reference[0], -0.1, atol=1e-12)
    assert bench.controller.settled


def test_while_others_move_the_arm_it_keeps_still_and_begins_where_they_leave_it(bench):
    bench.stands(0.1)
    bench.steps(5)
    assert bench.steps(20, Graph(others=True)) == [None] * 20
    bench.stands(0.4)
    assert (bench.steps(1)[0].setpoint == 0.4).all()


@pytest.mark.parametrize("strange", [False, True])
def test_unseen_a_trajectory_waits_for_the_arm_and_begins_at_0_where_nobody_is(bench, strange):
    nobody = replace(NOBODY, strange=strange)
    bench.controller.adjust(replace(SETTINGS, open_loop=strange))
    assert bench.go(0.1) is None
    assert bench.steps(150, nobody) == [None] * 150
    first = next(command for command in bench.steps(100, nobody) if command is not None)
    np.testing.assert_allclose(first.setpoint, 0.0, atol=MODEL.arm.v_max * 0.01)
    bench.steps(300, nobody)
    bench.stands(-0.5)  # somebody shows up after all
    assert bench.steps(1, HEARD) != [None]
    assert bench.said == ["the arm stands elsewhere than was thought: starting anew from there"]


def test_where_states_come_under_another_name_what_came_is_given_up(bench):
    nobody = Graph(said=False, strange=True, lacking="nobody publishes /trunk/gearbox_states")
    for command in (lambda: bench.go(0.1), lambda: bench.controller.refer(np.full(5, 0.1))):
        command()
        assert bench.steps(250, nobody) == [None] * 250
        bench.stands(0.3)  # too late: it was refused
        assert (bench.steps(1)[0].setpoint == 0.3).all()
        bench.controller.stop()
    told = f"refused: trunk/gearbox_states do not say where all joints stand: {nobody.lacking}"
    assert bench.said == [told] * 2


def test_a_command_is_given_up_where_nobody_says_all_joints(bench):
    bench.go(0.1)
    assert bench.steps(250) == [None] * 250
    assert bench.said == ["refused: trunk/gearbox_states do not say where all joints stand"]


def test_when_the_arm_is_lost_it_holds_and_refuses_others(bench):
    bench.stands(0.0)
    bench.steps(5)
    bench.go(0.3, 10.0)
    bench.steps(100)
    held = {tuple(command.reference[0]) for command in bench.steps(50, LOST)[1:]}
    assert len(held) == 1
    assert set(bench.over) == {"no trunk/gearbox_states"}
    with pytest.raises(MessageError, match="no trunk/gearbox_states"):
        bench.go(0.0, 1.0, LOST)


def test_while_the_arm_is_lost_setpoints_end_once_the_output_rests(bench):
    bench.stands(0.0)
    bench.steps(5)
    bench.go(0.3, 2.0)
    bench.steps(100)
    held = bench.steps(100, LOST)
    silent = [command.silent for command in held]
    assert not silent[0]
    assert silent == sorted(silent)
    assert silent[30:] == [True] * 70
    assert len({tuple(command.setpoint) for command in held[30:]}) == 1


def test_an_arm_that_was_only_unheard_is_held_where_it_was_sent_and_goes_on(bench):
    bench.stands(0.0)
    bench.steps(5)
    bench.go(0.3, 2.0)
    bench.steps(100)
    sent = bench.steps(100, LOST)[-1].setpoint
    bench.stands(sent[0])
    back = bench.steps(20)
    assert not any(command.silent for command in back)
    np.testing.assert_allclose(back[-1].setpoint, sent, atol=1e-4)
    assert bench.said == []
    bench.go(0.0)
    np.testing.assert_allclose(bench.steps(200)[-1].reference[0], 0.0, atol=1e-12)


@pytest.mark.parametrize("foreign", [False, True])
def test_an_arm_that_comes_back_elsewhere_is_not_sent_to_where_it_was(bench, foreign):
    bench.stands(0.0)
    bench.steps(5)
    if foreign:
        bench.controller.refer(np.full(5, 0.3))
    else:
        bench.go(0.3)
    assert bench.steps(200)[-1].setpoint[0] > 0.4
    bench.steps(100, LOST)
    bench.stands(-0.6)
    back = bench.steps(100)
    sent = [command.setpoint for command in back if not command.silent]
    assert len(sent) > 50
    assert (np.array(sent) == -0.6).all()
    assert bench.said == ["the arm is back, and stands elsewhere than it was sent: starting anew from there"]
    bench.go(0.0)
    path = np.array([-0.6, *(command.setpoint[0] for command in bench.steps(200))])
    assert np.abs(np.diff(path)).max() <= MODEL.arm.v_max * 0.01 + 1e-9


def test_an_arm_that_is_back_and_moves_is_waited_for(bench):
    bench.stands(0.0)
    bench.steps(5)
    bench.go(0.3)
    bench.steps(200)
    bench.steps(100, LOST)
    for tick in range(100):
        bench.stands(-0.6 + 0.005 * tick)
        assert bench.steps(1)[0].silent
    with pytest.raises(MessageError, match="it has to rest before"):
        bench.go(0.0)
    assert not bench.steps(40)[-1].silent


def test_states_that_were_late_in_mid_motion_are_no_arm_elsewhere(bench):
    bench.stands(0.0)
    bench.steps(5)
    bench.go(0.3, 1.0)
    bench.steps(50)
    sent = bench.steps(1, LOST)[0].setpoint[0]
    for lag in 0.075 * np.exp(-20 * 0.01 * np.arange(30)):  # as a servo catches up
        bench.stands(sent - lag)
        bench.steps(1)
    assert bench.said == []
    assert not bench.steps(1)[0].silent


def test_after_a_loss_where_the_arm_stood_before_is_not_where_it_stands(bench):
    bench.stands(0.2)
    bench.steps(5)
    bench.steps(5, Graph(others=True))
    bench.steps(5, LOST)
    bench.go(0.1)
    assert bench.steps(150, LOST) == [None] * 150
    bench.stands(-0.4)
    np.testing.assert_allclose(bench.steps(1)[0].setpoint, -0.4, atol=MODEL.arm.v_max * 0.01)


def test_a_refused_trajectory_changes_nothing(bench):
    bench.stands(0.2)
    before = bench.steps(5)[-1].setpoint
    with pytest.raises(TrajectoryError):
        bench.go(3.0)
    assert (bench.steps(5)[-1].setpoint == before).all()


def test_a_foreign_reference_has_precedence_until_the_next_trajectory(bench):
    bench.stands(0.0)
    bench.steps(5)
    bench.controller.refer(np.array([0.1, np.nan, np.nan, np.nan, np.nan]))
    command = bench.steps(200)[-1]
    assert command.reference is None
    np.testing.assert_allclose(bench.controller.reference, [0.1, 0, 0, 0, 0], atol=1e-12)
    bench.go(0.0)
    assert bench.steps(1)[-1].reference is not None
