"""A fitted arm as a vector environment of gymnasium: hundreds of arms with backlash and late sensors.

The task: hold random joint angles. An action is a change of the motor-side setpoint, an observation the
joints' readings and their targets, a reward less the squared error.
"""

from typing import Any

import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from trunk_ros.model import Model, load_model

STEP, LENGTH = 0.02, 100  # s a step, steps an episode
QUICKEST = 0.03  # rad a step, motor side
REACH = 0.3  # rad, of the targets


class HoldPosture(VectorEnv):
    """``Model.plant`` behind gymnasium's interface; environments begin anew by themselves."""

    metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(self, model: Model, environments: int):
        self.plant, self.num_envs = model.plant(environments), environments
        joints = len(self.plant.joints)
        self.single_action_space = Box(-1.0, 1.0, (joints,))
        self.single_observation_space = Box(-np.inf, np.inf, (2 * joints,))
        self.action_space = batch_space(self.single_action_space, environments)
        self.observation_space = batch_space(self.single_observation_space, environments)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict]:
        """All arms upright, each with a target of its own."""
        super().reset(seed=seed)
        self.reading = self.plant.reset()
        self.setpoints, self.target = np.zeros_like(self.reading), np.empty_like(self.reading)
        self.age = np.zeros(self.num_envs, int)
        self.over = np.zeros(self.num_envs, bool)
        self._aim(np.ones(self.num_envs, bool))
        return self._seen(), {}

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict]:
        """Actions (environments, joints) in -1 … 1. Arms whose episode has ended begin anew."""
        if self.over.any():
            self.plant.reset(self.over)
            self.setpoints[self.over], self.age[self.over] = 0.0, 0
            self._aim(self.over)
        self.setpoints += QUICKEST * np.clip(actions, -1.0, 1.0) * ~self.over[:, None]
        self.reading = self.plant.step(self.setpoints, STEP)
        self.age += ~self.over
        reward = -np.square(self.reading - self.target).sum(axis=1) * ~self.over
        self.over = self.age >= LENGTH
        return self._seen(), reward, np.zeros(self.num_envs, bool), self.over, {}

    def _aim(self, which: np.ndarray) -> None:
        self.target[which] = self.np_random.uniform(-REACH, REACH, (int(which.sum()), self.target.shape[1]))

    def _seen(self) -> np.ndarray:
        return np.hstack([self.reading, self.target]).astype(np.float32)


def proportional(seen: np.ndarray, gain: float = 6.0) -> np.ndarray:
    """A policy without learning: towards the target in proportion to what is left."""
    reading, target = np.split(seen, 2, axis=1)
    return np.clip(gain * (target - reading), -1.0, 1.0)


if __name__ == "__main__":
    nominal = load_model("trunk")
    found = Model(
        nominal.arm,
        {
            "backlash": {"half_width": np.array([4e-3, 0.0, 6e-3, 0.0, 0.0])},
            "sensor_delay": {"delay": 0.03},
        },
    )
    for name, model in (("nominal", nominal), ("fitted", found)):
        arms = HoldPosture(model, 256)
        seen, _ = arms.reset(seed=0)
        for _ in range(LENGTH):
            seen, reward, _, _, _ = arms.step(proportional(seen))
        reading, target = np.split(seen, 2, axis=1)
        off = 1e3 * np.sqrt(np.mean((reading - target) ** 2, axis=0))
        print(f"{name}: {arms.num_envs} arms, mrad rms off at the end: {', '.join(f'{x:.2f}' for x in off)}")
