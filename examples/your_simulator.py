"""What a simulator is missing, and how much nearer the arm it is with what was found.

Both runs stand for yours: "robot" is an arm whose joint_2 has more backlash than the simulation believes, and
pulls at joint_4. Both follow the same motor commands.
"""

import numpy as np

from trunk_ros.chain import Chain
from trunk_ros.diagnosis import diagnose
from trunk_ros.model import Model, load_model
from trunk_ros.recording.recording import Recording

RATE, NOISE = 100.0, 1e-4  # Hz, rad
ARM = load_model("trunk").arm
COUPLED = {
    "backlash": {"half_width": np.array([0.0, 2e-3, 0.0, 0.0, 0.0])},
    "joint_coupling": {
        "gain": np.array([0.0, 0.0, 0.0, 0.02, 0.0]),
        "source": ["", "", "", "joint_2", ""],
    },
}


def run(model: Model, seed: int, noise: float) -> Recording:
    """A model's joints under motor angles that depend on the seed alone."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 40.0, 1.0 / RATE)
    rates, phases = rng.uniform(0.05, 0.5, (4, 5)), rng.uniform(0.0, 6.0, (4, 5))
    motor = 0.1 * np.sin(2.0 * np.pi * t[:, None, None] * rates + phases).sum(axis=1)
    joint = Chain(model, "wire").run(motor, t)[0] + rng.normal(0.0, 1.0, motor.shape) * noise
    return Recording.from_arrays(t, motor, joint, joints=ARM.joints)


if __name__ == "__main__":
    robot, simulation = Model(ARM, COUPLED), Model(ARM)
    result = diagnose(run(robot, 1, NOISE), against=run(simulation, 1, 0.0))
    print(result)
    unseen = run(robot, 2, NOISE)
    for name, model in (("simulation", simulation), ("with what was found", result.model)):
        worst = max(model.score(unseen).items(), key=lambda one: one[1])
        print(f"{name}: {1e3 * worst[1]:.2f} mrad rms on {worst[0]}, the worst joint of run 2")
