"""YAML from strangers: small, without the constructs that grow when they are read."""

import json
from typing import Any

import yaml

from trunk_ros.recording import allowance

_LARGEST, _DEEPEST = 32 << 20, 64  # bytes; lists within lists
_MOST = 1_000_000  # values: each takes 300 bytes, and 10 us to read
_LONGEST = 40  # digits of a whole number
_NUMBERS = {"tag:yaml.org,2002:int": "construct_yaml_int", "tag:yaml.org,2002:float": "construct_yaml_float"}
_Base: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Loader(_Base):  # type: ignore[misc]
    """Without merge keys, as nested ones multiply, keys given twice, and numbers to the base of 60."""

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        seen = set()
        for key, _ in node.value:
            if key.tag == "tag:yaml.org,2002:merge":
                raise yaml.constructor.ConstructorError(None, None, "merge keys", key.start_mark)
            if key.value.__hash__ is not None and key.value in seen:
                raise yaml.constructor.ConstructorError(None, None, "a key given twice", key.start_mark)
            seen.add(key.value if key.value.__hash__ is not None else id(key))

    def number(self, node: yaml.ScalarNode) -> Any:
        """A number; what has colons is text, as in YAML 1.2: to read it takes the square of its length."""
        text = self.construct_scalar(node)
        if ":" in text:
            return text
        if len(text) > _LONGEST and node.tag.endswith("int"):
            raise yaml.constructor.ConstructorError(None, None, "too many digits", node.start_mark)
        return getattr(self, _NUMBERS[node.tag])(node)


for _tag in _NUMBERS:
    _Loader.add_constructor(_tag, _Loader.number)


class _Dumper(yaml.SafeDumper):  # type: ignore[misc]
    """Writes everything out: other readers do not expect YAML's references."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


class _ReferenceError(Exception):
    """A reference where there may be none."""


class _LargeError(Exception):
    """More values than a file of that kind has."""


def load(data: bytes, references: bool = True) -> Any:
    """Content of a YAML text; ValueError says in one line what is wrong with it, and where.

    references: whether it may refer to its own parts, which parameter files of ROS 2 may not.
    """
    if len(data) > _LARGEST and not allowance.is_lifted():
        raise ValueError(f"is larger than {_LARGEST >> 20} MB: give {allowance.OPTION} if it is meant to be")
    try:
        if _has_references(data) and not references:
            raise _ReferenceError
        return yaml.load(data, Loader=_Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        what = getattr(error, "problem", None) or getattr(error, "reason", "")
        place = f" in line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        raise ValueError(f"is not YAML{place}{f' ({what})' if what else ''}") from None
    except _LargeError:
        raise ValueError(
            f"holds more than {_MOST} values: give {allowance.OPTION} if it is meant to"
        ) from None
    except _ReferenceError:
        raise ValueError("refers to its own parts: write them out") from None
    except (ValueError, RecursionError, ArithmeticError, AttributeError, TypeError, LookupError):
        raise ValueError("is not YAML") from None


def _has_references(data: bytes) -> bool:
    """Whether there are references. Deep nesting overflows the stack of the C loader: nothing catches it."""
    depth, references = 0, False
    for number, event in enumerate(yaml.parse(data, Loader=_Loader)):
        if number > _MOST and not allowance.is_lifted():
            raise _LargeError
        references |= isinstance(event, yaml.AliasEvent)
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > _DEEPEST:
            raise ValueError("nested too deeply")
    return references


def scalar(value: Any) -> str:
    """The text of a single value; TypeError for lists and tables, which references can make endless."""
    if not isinstance(value, str | int | float | None):
        raise TypeError("a list where a single value is expected")
    return str(value)


def dump(content: Any) -> str:
    """YAML that other readers take: in order, and without references."""
    return str(yaml.dump(content, Dumper=_Dumper, sort_keys=False))


def plain(text: str) -> str:
    """Text as a value between braces or brackets: in quotes where YAML takes it for something else."""
    try:
        as_it_is = load(f"[{text}]".encode()) == [text]
    except ValueError:
        as_it_is = False
    return text if as_it_is else json.dumps(text, ensure_ascii=False)
