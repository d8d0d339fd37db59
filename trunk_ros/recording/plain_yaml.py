"""YAML from strangers: small, without the constructs that grow when they are read."""

from typing import Any

import yaml

_LARGEST, _DEEPEST = 32 << 20, 64
_Base: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Loader(_Base):  # type: ignore[misc]
    """Without merge keys: nested ones multiply."""

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        for key, _ in node.value:
            if key.tag == "tag:yaml.org,2002:merge":
                raise yaml.constructor.ConstructorError(None, None, "merge keys", key.start_mark)


class _Dumper(yaml.SafeDumper):  # type: ignore[misc]
    """Writes everything out: other readers do not expect YAML's references."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


class _ReferenceError(Exception):
    """A reference where there may be none."""


def load(data: bytes, references: bool = True) -> Any:
    """Content of a YAML text; ValueError says in one line what is wrong with it, and where.

    references: whether it may refer to its own parts, which parameter files of ROS 2 may not.
    """
    if len(data) > _LARGEST:
        raise ValueError(f"is larger than {_LARGEST >> 20} MB")
    try:
        if _check_depth(data) and not references:
            raise _ReferenceError
        return yaml.load(data, Loader=_Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        raise ValueError(f"is not YAML{f' in line {mark.line + 1}' if mark else ''}") from None
    except _ReferenceError:
        raise ValueError("refers to its own parts: write them out") from None
    except (ValueError, RecursionError, OverflowError, AttributeError, TypeError):
        raise ValueError("is not YAML") from None


def _check_depth(data: bytes) -> bool:
    """Whether there are references. Deep nesting overflows the stack of the C loader: nothing catches it."""
    depth, references = 0, False
    for event in yaml.parse(data, Loader=_Loader):
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
