"""Arithmetic on named columns, and nothing else: `hub_angle_rad + tip_deflection_m / 0.45`.

A column whose name is no identifier is put in quotes: `radians('/encoder.data')`.
"""

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from trunk_ros.recording.recording import Floats

_LONGEST, _DEEPEST = 1000, 100
_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
}
_UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {ast.USub: np.negative, ast.UAdd: np.positive}
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "abs": np.abs,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "radians": np.radians,
    "degrees": np.degrees,
    "nonzero": lambda x: np.where(x == 0, np.nan, x),  # where a sensor says 0 when it sees nothing
}
_CONSTANTS = {"pi": np.pi}


@dataclass(frozen=True)
class Expression:
    """An expression of columns. text: as it was given; columns: the names that it needs."""

    text: str
    columns: tuple[str, ...]
    tree: ast.expr | None = None

    def evaluate(self, table: Mapping[str, Floats]) -> Floats:
        """(rows,) values; NaN and infinity where the arithmetic gives them."""
        if self.tree is None:
            return table[self.text]
        with np.errstate(all="ignore"):
            value = np.asarray(_value(self.tree, table), dtype=np.float64)
        return np.broadcast_to(value, next(iter(table.values())).shape).astype(np.float64)


def column(name: str) -> Expression:
    """A column as it is, whatever its name looks like."""
    return Expression(name, (name,))


def parse(text: str) -> Expression:
    """An expression with + - * / ** and the functions above. ValueError says what it may not hold."""
    if len(text) > _LONGEST:
        raise ValueError(f"is longer than {_LONGEST} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
        names = tuple(dict.fromkeys(_names(tree)))
    except (SyntaxError, RecursionError, MemoryError) as error:
        raise ValueError(f"is not arithmetic ({getattr(error, 'msg', 'too deep')})") from None
    if not names:
        raise ValueError("names no column")
    return Expression(text, names, tree)


def _names(node: ast.expr, depth: int = 0) -> list[str]:
    """Columns of a tree; ValueError at anything that is not arithmetic, or that is nested without end."""
    if depth > _DEEPEST:
        raise ValueError("is nested too deeply")
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return []
    if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value:
        return [node.value]  # a column that is no name, in quotes
    if isinstance(node, ast.Name):
        return [] if node.id in _CONSTANTS else [node.id]
    if isinstance(node, ast.UnaryOp) and type(node.op) in _UNARY:
        return _names(node.operand, depth + 1)
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        return _names(node.left, depth + 1) + _names(node.right, depth + 1)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        _check_call(node.func.id, len(node.args))
        return [name for each in node.args for name in _names(each, depth + 1)]
    raise ValueError(f"may hold columns, numbers, + - * / ** and {', '.join(_FUNCTIONS)}")


def _check_call(name: str, arguments: int) -> None:
    if name not in _FUNCTIONS:
        raise ValueError(f"calls {name}: there are {', '.join(_FUNCTIONS)}")
    wanted = 2 if name == "atan2" else 1
    if arguments != wanted:
        raise ValueError(f"gives {name} {arguments} arguments, not {wanted}")


def _value(node: ast.expr, table: Mapping[str, Floats]) -> Any:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return table[node.value]
    if isinstance(node, ast.Constant):
        return float(str(node.value))  # a float from the start: 9**9**9 must overflow, not run for ever
    if isinstance(node, ast.Name):
        return _CONSTANTS[node.id] if node.id in _CONSTANTS else table[node.id]
    if isinstance(node, ast.UnaryOp):
        return _UNARY[type(node.op)](_value(node.operand, table))
    if isinstance(node, ast.BinOp):
        return _BINARY[type(node.op)](_value(node.left, table), _value(node.right, table))
    assert isinstance(node, ast.Call)
    assert isinstance(node.func, ast.Name)
    return _FUNCTIONS[node.func.id](*[_value(each, table) for each in node.args])
