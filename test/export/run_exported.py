"""Runs an exported MuJoCo model with its reality layer: python -m test.export.run_exported FOLDER."""

from __future__ import annotations

import sys
from pathlib import Path

import mujoco
import numpy as np

from trunk_ros.compiled import Array
from trunk_ros.export.mjcf import MjcfWriter
from trunk_ros.export.reality import RealityLayer
from trunk_ros.model import load_model

TICK = 0.01  # s


def run_exported(path: Path, layer: RealityLayer | None, joints: tuple[str, ...], commands: Array) -> Array:
    """What the joints show (n, joints) rad at each tick before its command acts."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    per = round(TICK / model.opt.timestep)
    for joint, angle in zip(joints, commands[0] / model.actuator_gear[:, 0], strict=True):
        data.qpos[model.joint(joint).qposadr[0]] = angle
    data.act[:] = commands[0][model.actuator_actadr >= 0]
    sensors = [model.sensor(f"{joint}_encoder") for joint in joints]
    shown = np.empty_like(commands)
    for k, command in enumerate(commands):
        mujoco.mj_forward(model, data)  # sensors of a step are those of its beginning
        state = np.array([data.sensordata[sensor.adr[0]] for sensor in sensors])
        if layer is not None:
            command, state = layer.step(command, state, TICK)
        shown[k] = state
        data.ctrl[:] = command
        for _ in range(per):
            mujoco.mj_step(model, data)
    return shown


def main(folder: Path) -> int:
    """``exported.xml`` (and its reality layer) under ``judged.npy`` into ``shown.npy``."""
    commands = np.load(folder / "judged.npy")
    path, beside = folder / "exported.xml", folder / "exported.reality.yaml"
    joints = load_model(folder / "arm.yaml").arm.joints
    layer = None
    if beside.is_file():
        model = load_model(beside)
        layer = RealityLayer(model, lag=MjcfWriter(model, path).lags())
    np.save(folder / "shown.npy", run_exported(path, layer, joints, commands))
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
