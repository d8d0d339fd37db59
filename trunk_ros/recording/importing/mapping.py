"""MAP.yaml of `import`: which columns of a table, or fields of a bag's messages, are which topic."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trunk_ros.errors import RecordingError, printable
from trunk_ros.recording import plain_yaml
from trunk_ros.recording.importing import expression
from trunk_ros.recording.importing.expression import Expression
from trunk_ros.recording.importing.units import DATES, QUANTITIES, TIME_UNITS, UNITS
from trunk_ros.recording.plain_yaml import scalar
from trunk_ros.recording.topics import JOINT_TOPICS
from trunk_ros.share import config_names, config_path

TOPICS = tuple(key for key in JOINT_TOPICS if key != "wire_states")
_KEYS = ("time", "rate_hz", "joints", "delimiter", "decimal", *TOPICS)


@dataclass(frozen=True)
class Quantity:
    """Columns of one quantity of a topic, one per joint: what they hold, and in which unit."""

    columns: tuple[Expression, ...]
    units: tuple[str, ...]


@dataclass(frozen=True)
class Mapping:
    """time: expression and s per unit, or None; rate_hz: where there is no time. topics: key -> quantity;
    dates: the columns of time hold dates, which count in s since 1970.
    """

    joints: tuple[str, ...]
    time: tuple[Expression, float] | None
    rate_hz: float
    topics: dict[str, dict[str, Quantity]]
    delimiter: str = ","
    decimal: str = "."
    dates: bool = False

    @property
    def of_bag(self) -> bool:
        """Whether the columns are fields of messages, which have their own times."""
        return self.time is None and not self.rate_hz

    @property
    def columns(self) -> tuple[str, ...]:
        """Every column that is needed."""
        return tuple(dict.fromkeys((*_columns(self.topics), *self.time_columns)))

    @property
    def time_columns(self) -> tuple[str, ...]:
        """Those that the time needs."""
        return self.time[0].columns if self.time else ()

    def units(self) -> dict[str, str]:
        """SI unit of position of each joint, as its last topic has it: joint_states comes last."""
        found = {}
        for topic in sorted(self.topics, key=TOPICS.index):
            if "position" in self.topics[topic]:
                units = self.topics[topic]["position"].units
                found.update({joint: UNITS[unit][0] for joint, unit in zip(self.joints, units, strict=True)})
        return found


def _columns(topics: dict[str, dict[str, Quantity]]) -> list[str]:
    used = [each for topic in topics.values() for one in topic.values() for each in one.columns]
    return [name for each in used for name in each.columns]


def load_mapping(name: str | Path) -> Mapping:
    """The mapping of a file, or of a name in config/import; RecordingError in one line."""
    path = Path(name)
    if not path.is_file():
        names = [each.removeprefix("import/") for each in config_names("import")]
        if str(name) not in names:
            raise RecordingError(f"{name}: no such mapping: give a file, or one of {', '.join(names)}")
        path = config_path(f"import/{name}")
    try:
        return parse_mapping(plain_yaml.load(path.read_bytes()))
    except OSError as error:
        raise RecordingError(f"cannot read the mapping {name}: {error.strerror}") from None
    except (TypeError, ValueError) as error:
        raise RecordingError(f"{name}: {' '.join(str(error).split())}") from None


def parse_mapping(content: Any) -> Mapping:
    """A mapping from what its YAML holds; ValueError says which entry is wrong, and what there could be."""
    table = _table(content, "the mapping", _KEYS)
    joints = _names(table.get("joints"))
    topics = {key: _topic(key, table[key], len(joints)) for key in TOPICS if key in table}
    if not topics:
        raise ValueError(f"names no topic: at least one of {', '.join(TOPICS)}")
    time = _time(table["time"]) if "time" in table else None
    rate = _positive(table["rate_hz"]) if "rate_hz" in table else 0.0
    of_bag = all(column.startswith("/") for column in _columns(topics))
    if (time is not None and rate) or not (time or rate or of_bag):
        raise ValueError("give either `time: {column: …, unit: s}` or `rate_hz`")
    delimiter = table.get("delimiter", ",")
    if not isinstance(delimiter, str) or len(delimiter) != 1 or delimiter in '\r\n"':
        raise ValueError("delimiter: must be one character")
    decimal = table.get("decimal", ".")
    if decimal not in (".", ",") or decimal == delimiter:
        raise ValueError('decimal: must be "." or ",", and not the delimiter')
    dates = time is not None and table["time"].get("unit") == DATES
    return Mapping(joints, time, rate, topics, delimiter, decimal, dates)


def _table(content: Any, where: str, keys: tuple[str, ...]) -> dict[str, Any]:
    if not isinstance(content, dict):
        raise ValueError(f"{where} must hold entries of {', '.join(keys)}")
    for key in content:
        if key not in keys:
            raise ValueError(f"{where} has no entry {scalar(key)[:40]!r}: there are {', '.join(keys)}")
    return content


def _names(value: Any) -> tuple[str, ...]:
    good = isinstance(value, list) and value and all(isinstance(each, str) and each for each in value)
    if not good or len(set(value)) < len(value):
        raise ValueError("joints: must be a list of different names")
    return tuple(printable(each) for each in value)


def _positive(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < 1e9:
        raise ValueError("rate_hz: must be a number above 0")
    return float(value)


def _time(value: Any) -> tuple[Expression, float]:
    if isinstance(value, dict) and "rate_hz" in value:
        raise ValueError("time: rate_hz is an entry of its own, beside joints, and takes the place of time")
    table = _table(value, "time", ("column", "unit"))
    unit = table.get("unit", "s")
    if scalar(unit) not in (*TIME_UNITS, DATES):
        raise ValueError(f"time: unit {scalar(unit)[:20]!r} is none of {', '.join((*TIME_UNITS, DATES))}")
    return _column(table.get("column"), "time"), TIME_UNITS.get(str(unit), 1.0)


def _topic(key: str, value: Any, joints: int) -> dict[str, Quantity]:
    table = _table(value, key, tuple(QUANTITIES))
    if "position" not in table:
        raise ValueError(f"{key}: has no position")
    return {name: _quantity(f"{key}.{name}", name, each, joints) for name, each in table.items()}


def _quantity(where: str, name: str, value: Any, joints: int) -> Quantity:
    table = _table(value, where, ("columns", "unit"))
    columns, units = table.get("columns"), table.get("unit")
    if not isinstance(columns, list) or len(columns) != joints:
        raise ValueError(f"{where}: columns must be a list with one for each of the {joints} joints")
    units = units if isinstance(units, list) else [units] * joints
    texts = tuple(scalar(unit) for unit in units)
    if len(texts) != joints or any(unit not in QUANTITIES[name] for unit in texts):
        raise ValueError(f"{where}: unit must be one of {', '.join(QUANTITIES[name])}, or a list of {joints}")
    return Quantity(tuple(_column(each, where) for each in columns), texts)


def _column(value: Any, where: str) -> Expression:
    if isinstance(value, str) and value:
        return expression.column(value)
    if isinstance(value, dict) and list(value) == ["expr"] and isinstance(value["expr"], str):
        try:
            return expression.parse(value["expr"])
        except ValueError as error:
            raise ValueError(f"{where}: {value['expr'][:60]!r} {error}") from None
    raise ValueError(f"{where}: a column is a name or {{expr: …}}")
