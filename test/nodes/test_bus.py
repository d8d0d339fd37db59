"""The simulated bus is the servo stage of the model, read tick by tick."""

import numpy as np
import pytest

from trunk_ros.chain import Chain
from trunk_ros.errors import ArgumentError
from trunk_ros.model import load_model
from trunk_ros.nodes.bus import SimulatedBus, bus_of

MODEL = load_model("trunk")
COUNT = 2 * np.pi / 2**17


def test_reading_tick_by_tick_gives_what_the_whole_recording_gives():
    rng = np.random.default_rng(2)
    stamp = np.arange(200) * 0.01
    setpoints = np.cumsum(rng.normal(0, 0.02, (200, 5)), axis=0)
    setpoints -= setpoints[0]
    whole, _ = Chain(MODEL, "servo").run(setpoints, stamp)
    bus, read = SimulatedBus(MODEL), []
    for at, setpoint in zip(stamp, setpoints, strict=True):
        read.append(bus.read(at).position)
        bus.write(setpoint, at)
    np.testing.assert_allclose(read, whole, atol=COUNT)


def test_a_setpoint_acts_from_its_stamp_on():
    early, late = SimulatedBus(MODEL), SimulatedBus(MODEL)
    for bus, begin in ((early, 0.0), (late, 0.05)):
        bus.read(0.0)
        bus.write(np.full(5, 0.1), begin)
    assert (late.read(0.05).position == 0).all()
    for step in range(6, 16):
        late.read(step * 0.01)
    np.testing.assert_allclose(early.read(0.1).position, late.read(0.15).position, atol=2e-3)


def test_position_comes_in_encoder_counts():
    bus = SimulatedBus(MODEL)
    bus.read(0.0)
    bus.write(np.full(5, 0.1), 0.0)
    counts = bus.read(0.03).position / COUNT
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    assert (counts > 0).all()


def test_the_motor_pulls_against_the_load_and_friction():
    bus = SimulatedBus(MODEL, np.full(5, 0.3))
    bus.read(0.0)
    np.testing.assert_allclose(beyond_weight(bus.read(0.5)), 0.0, atol=1e-5)
    bus.write(np.full(5, 0.35), 0.5)
    assert (beyond_weight(bus.read(0.52)) > 5e-4).all()
    bus.write(np.full(5, 0.2), 0.52)
    assert (beyond_weight(bus.read(0.6)) < -5e-4).all()


def beyond_weight(sample):
    return sample.effort + 0.625 * MODEL.arm.load(0.625 * sample.position[None])[0]


@pytest.mark.parametrize(
    "name", ["os:system", "os:path", "os:nothing", "no_such_module:Bus", "math:pi", "simulate", ":"]
)
def test_what_is_no_bus_is_refused_and_not_called(name):
    with pytest.raises(ArgumentError, match="bus"):
        bus_of(name, MODEL)
