"""``check``: whether a model file, a mapping or a trajectory is right, and how it is understood."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from trunk_ros.console.arguments import Parser
from trunk_ros.console.console import columns, say

if TYPE_CHECKING:
    from trunk_ros.arm import Arm
    from trunk_ros.compiled import Array
    from trunk_ros.model import Model
    from trunk_ros.recording.importing.mapping import Mapping, Quantity
    from trunk_ros.trajectory import Trajectory


def parser() -> Parser:
    """Arguments of ``check``."""
    made = Parser(
        "check",
        "Say whether a model file, a mapping or a trajectory is right, and how it is understood.",
        ["my-arm.yaml", "my-map.yaml", "trunk"],
    )
    made.add_argument("file", metavar="MODEL|MAP", help="a file, or the name of a model or of a mapping")
    return made


def main(argv: list[str]) -> int:
    """The command; raises TrunkError for a file that is wrong."""
    name = parser().parse_args(argv).file
    kind, sound = kind_of(name), "right"
    if kind == "mapping":
        from trunk_ros.recording.importing.mapping import load_mapping

        said = of_mapping(load_mapping(name))
    elif kind == "trajectory":
        from trunk_ros.trajectory import load_trajectory

        said = of_trajectory(load_trajectory(name))
    else:
        from trunk_ros.model import load_model
        from trunk_ros.parameter_file import model_path, read_parameters

        given = read_parameters(model_path(name))
        refused = _refused_by_nodes(given)
        said = [*refused, *of_model(load_model(name), given)]
        sound = "right for all but nodes" if refused else sound
    say(f"{name}: a {kind}, and {sound}", *(f"  {line}" for line in said))
    return 0


def kind_of(name: str) -> str:
    """Model, mapping or trajectory, by what the file holds; a name is a model's, if it is not a mapping's.

    Raises ArgumentError where it is none of them.
    """
    from trunk_ros.commands.info import TABLES
    from trunk_ros.errors import ArgumentError
    from trunk_ros.recording import plain_yaml
    from trunk_ros.share import config_names

    path = Path(name)
    if path.is_dir() or path.suffix in (".mcap", ".db3", ".bag"):
        raise ArgumentError(f"{path} is a recording, if anything: `trunk_ros info {path}` says what it holds")
    if path.suffix.lower() in TABLES:
        raise ArgumentError(f"{path} is a table, if anything: `trunk_ros info {path}` lists its columns")
    if not path.is_file():
        return "mapping" if f"import/{name}" in config_names("import") else "model"
    try:
        content = plain_yaml.load(path.read_bytes(), references=False)
    except OSError as error:
        raise ArgumentError(f"cannot read {path}: {error.strerror}") from None
    except ValueError as error:
        raise ArgumentError(f"{path} {error}") from None
    keys = set(content) if isinstance(content, dict) else set()
    if "points" in keys:
        return "trajectory"
    if any(isinstance(each, dict) and "ros__parameters" in each for each in _values(content)):
        return "model"
    if "joints" in keys or any(str(key).endswith("_states") for key in keys):
        return "mapping"
    raise ArgumentError(
        f"{path} is neither a model ('/**: ros__parameters:'), nor a mapping ('joints:'), nor a trajectory "
        f"('points:'); it holds {', '.join(map(str, keys)) or 'no entries'}"
    )


def _values(content: Any) -> list[Any]:
    return list(content.values()) if isinstance(content, dict) else []


def of_model(model: Model, given: dict[str, Any]) -> list[str]:
    """An arm joint by joint, what is known of it besides, and the effects that it has; ``given``: the file's
    parameters.
    """
    from trunk_ros.arm.parameters import ANY_ANGLE
    from trunk_ros.units import sized

    arm = model.arm
    rows = [("joint", "ratio" if arm.coupling is None else "of the motors", "backlash", "limits")]
    for j, joint in enumerate(arm.joints):
        low, high, unit = float(arm.lower[j]), float(arm.upper[j]), arm.units.get(joint, "rad")
        limits = f"{low:+.3f} … {high:+.3f} {unit}" if max(-low, high) < ANY_ANGLE else "none"
        name = "any joint" if model.any_joints else joint
        rows.append((name, _moved_by(arm, j), sized(float(arm.dead_band[j]), unit), limits))
    effects = [f"effect {name}: {_said(values)}" for name, values in model.in_order()]
    return [
        *columns(rows),
        f"load: {_load(arm)}",
        f"tip: {_tip(arm)}",
        f"servo: {_servo(arm, given)}",
        *(effects or ["effects: none"]),
        *_wide(arm),
    ]


def _moved_by(arm: Arm, j: int) -> str:
    """The ratio of joint ``j``, or which motors move it, and how far."""
    if arm.coupling is None:
        return f"{arm.ratio[j]:.6g}"
    parts = zip(arm.coupling[j].tolist(), arm.motors or arm.joints, strict=True)
    return " + ".join(f"{part:.6g} {motor}" for part, motor in parts if part).replace("+ -", "- ")


def _wide(arm: Arm) -> list[str]:
    """Joints whose limits lie beyond a turn, where these may be degrees."""
    import numpy as np

    from trunk_ros.arm.parameters import ANY_ANGLE

    far = np.maximum(np.abs(arm.lower), np.abs(arm.upper))
    wide = [
        joint
        for joint, limit in zip(arm.joints, far, strict=True)
        if 2.0 * np.pi < limit < ANY_ANGLE and arm.units.get(joint, "rad") == "rad"
    ]
    return [f"limits of {', '.join(wide)} are beyond a turn: are these rad, not degrees?"] if wide else []


def _load(arm: Arm) -> str:
    """Where it comes from: recorded effort stands for masses that nobody knows."""
    unknown = "unknown: effects of load are not tried"
    if arm.load_from == "effort":
        return f"from recorded effort; without any, {'the computed weight' if arm.has_load else unknown}"
    return f"known, from {arm.load_from}" if arm.has_load else unknown


def _tip(arm: Arm) -> str:
    if arm.description is not None:
        return f"{arm.description.tip}, seen from {arm.description.base}, by the URDF"
    if arm.has_geometry:
        return f"links of {', '.join(f'{1e3 * x:g}' for x in arm.link_length)} mm"
    return "not known: neither link lengths nor a URDF, so no arm stage"


def _listed(number: float | Array) -> str:
    values = [number] if isinstance(number, float) else number.tolist()
    return "/".join(f"{value:.4g}" for value in values)


def _servo(arm: Arm, given: dict[str, Any]) -> str:
    """Its numbers, and which of them are not the file's."""
    import numpy as np

    from trunk_ros.arm.arm import STEP

    units = {"kp": " 1/s", "tau_v": " s", "v_max": " rad/s"}
    if np.any(arm.delay):
        units["delay"] = " s"
    if np.any(arm.feedforward):
        units["feedforward"] = ""
    if arm.step != STEP:
        units["step"] = " s"
    numbers = ", ".join(f"{name} {_listed(getattr(arm, name))}{unit}" for name, unit in units.items())
    if not arm.servo_stated:
        return f"not given: a diagnosis finds it in the recording, a simulation takes {numbers}"
    taken = [name for name in units if f"servo.{name}" not in given]
    return numbers + (f" (not given, taken from trunk: {', '.join(taken)})" if taken else "")


def _refused_by_nodes(given: dict[str, Any]) -> list[str]:
    """Lists that the tools read and ROS 2 does not."""
    from trunk_ros.arm.parameters import shortened

    return [
        f"{name} = {shortened(value)}: nodes refuse this file as --params-file, as ROS 2 wants every "
        "number of a list with a decimal point or none: write 1.0, not 1"
        for name, value in given.items()
        if isinstance(value, list) and {type(each) for each in value} == {int, float}
    ]


def _said(values: dict[str, Any]) -> str:
    def plain(value: Any) -> str:
        if isinstance(value, str):
            return value
        if isinstance(value, float):
            return f"{value:.4g}"
        return "[" + ", ".join(v if isinstance(v, str) else f"{v:.4g}" for v in value) + "]"

    return ", ".join(f"{key} {plain(value)}" for key, value in values.items())


def of_mapping(mapping: Mapping) -> list[str]:
    """Joints, times, and the columns of each topic with their units."""
    if mapping.of_bag:
        time = "that of the bag's messages"
    elif mapping.time is not None:
        unit = "date and time in ISO 8601" if mapping.dates else f"{mapping.time[1]:g} s per unit"
        time = f"column {', '.join(mapping.time_columns)}, {unit}"
    else:
        time = f"{mapping.rate_hz:g} rows a second"
    rows = [
        (topic, quantity, ", ".join(sorted(set(each.units))), ", ".join(_columns(each)))
        for topic, quantities in mapping.topics.items()
        for quantity, each in quantities.items()
    ]
    return [
        f"joints: {', '.join(mapping.joints)}",
        f"time: {time}",
        *columns([("topic", "quantity", "unit", "columns"), *rows]),
        *_lacking(mapping),
    ]


def _columns(quantity: Quantity) -> list[str]:
    return [name for each in quantity.columns for name in each.columns]


def _lacking(mapping: Mapping) -> list[str]:
    """What the wire needs and the mapping does not give."""
    wanted = ("gearbox_states", "joint_states")
    return [f"no {key}: the wire cannot be diagnosed" for key in wanted if key not in mapping.topics]


def of_trajectory(trajectory: Trajectory) -> list[str]:
    """Joints, duration and range."""
    rows = [
        (joint, f"{low:+.3f} … {high:+.3f} rad")
        for joint, low, high in zip(
            trajectory.joints, trajectory.position.min(axis=0), trajectory.position.max(axis=0), strict=True
        )
    ]
    return [f"{trajectory.duration:.4g} s, {len(trajectory.time)} points", *columns(rows)]
