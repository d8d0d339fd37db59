"""What was fitted, and its file."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from trunk_ros.errors import ModelError
from trunk_ros.recording import plain_yaml

SCHEMA = "trunk_ros/bodies/1"
UNITS = {
    "friction": ("N m", "N"),
    "damping": ("N m s/rad", "N s/m"),
    "armature": ("kg m^2", "kg"),
    "offset": ("N m", "N"),
}
"""Of a joint that turns, and of one that slides."""
HEAD = """\
# Friction, armature and the last link, at the joints: torque there is the motor's effort over the ratio.
# friction: Coulomb; damping: viscous; armature: the rotor's inertia; offset: of the torque sensor.
# centre: of mass, in the frame of its joint. std: standard deviation.
"""


@dataclass(frozen=True)
class Value:
    """A number with its standard deviation."""

    value: float
    std: float
    unit: str


@dataclass(frozen=True)
class Centre:
    """Centre of mass [m] in the frame of the last joint (of a planar chain: x along the axis, z along the
    link). Where ``std`` is None a coordinate was not seen, and is the model's.
    """

    value: tuple[float, float, float]
    std: tuple[float | None, float | None, float | None]
    for_mass: float
    """kg with which the centre has the weight's moment that was seen: the mass found, else the model's."""
    unit: str = "m"


@dataclass(frozen=True)
class Bodies:
    """What a motion shows of friction, armature and of all that is fixed to the last joint."""

    recordings: tuple[str, ...]
    joints: dict[str, dict[str, Value]]
    """By joint and name of UNITS; what was not seen is not there."""
    last: str
    """The last joint."""
    mass: Value | None = None
    """Of all that is fixed to it, payload aside."""
    centre: Centre | None = None
    not_seen: tuple[str, ...] = ()
    """What was left out and why, a sentence each."""
    held_out: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Rms torque error on unseen blocks by joint: ``before``, ``after``, ``unit``."""

    def of(self, joint: str, name: str) -> float | None:
        """A value, where it was seen."""
        found = self.joints.get(joint, {}).get(name)
        return None if found is None else found.value

    @property
    def pull_at_motors(self) -> bool:
        """Whether friction or a mass was found, which keep a motor off its command."""
        return self.mass is not None or any("friction" in own for own in self.joints.values())

    def to_json(self) -> dict[str, Any]:
        """As the file has it."""
        link: dict[str, Any] = {"joint": self.last}
        if self.mass is not None:
            link["mass"] = asdict(self.mass)
        if self.centre is not None:
            own = self.centre
            link["centre"] = asdict(own) | {"value": list(own.value), "std": list(own.std)}
        return {
            "schema": SCHEMA,
            "recordings": list(self.recordings),
            "joints": {j: {n: asdict(v) for n, v in own.items()} for j, own in self.joints.items()},
            "last_link": link,
            "not_seen": list(self.not_seen),
            "held_out": self.held_out,
        }


def save_bodies(bodies: Bodies, path: Path) -> None:
    """Write the file."""
    path.write_text(HEAD + plain_yaml.dump(bodies.to_json()), encoding="utf-8")


def load_bodies(path: str | Path) -> Bodies:
    """Read the file. Raises ModelError in one line where it is none."""
    try:
        content = plain_yaml.load(Path(path).read_bytes(), references=False)
        if not isinstance(content, dict) or content.get("schema") != SCHEMA:
            raise ModelError(f"{path} is no {SCHEMA}: `trunk_ros bodies` writes one")
        return _bodies(content)
    except OSError as error:
        raise ModelError(f"cannot read {path}: {error.strerror}") from None
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ModelError(f"{path} is not as `trunk_ros bodies` writes it: {error}") from None


def _bodies(content: dict[str, Any]) -> Bodies:
    link = content["last_link"]
    own = link.get("centre")
    centre = None
    if own is not None:
        x, y, z = map(_finite, own["value"])
        sx, sy, sz = (None if std is None else _finite(std) for std in own["std"])
        centre = Centre((x, y, z), (sx, sy, sz), _finite(own["for_mass"]))
    return Bodies(
        tuple(map(str, content.get("recordings", ()))),
        {str(j): {str(n): _value(v) for n, v in own.items()} for j, own in content["joints"].items()},
        str(link["joint"]),
        _value(link["mass"]) if "mass" in link else None,
        centre,
        tuple(map(str, content.get("not_seen", ()))),
        dict(content.get("held_out", {})),
    )


def _value(told: dict[str, Any]) -> Value:
    return Value(_finite(told["value"]), _finite(told["std"]), str(told["unit"]))


def _finite(value: Any) -> float:
    number = float(value)
    if not abs(number) < float("inf"):
        raise ValueError(f"{value} is no number")
    return number
