"""numba's ``njit`` with a type that strict checking understands, and without numba until something is run."""

import hashlib
from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

Function = TypeVar("Function", bound=Callable[..., Any])
Array = NDArray[np.float64]


class Compiled:
    """A function that numba compiles when it is first called, from Python or from one that is compiled."""

    def __init__(self, function: Callable[..., Any]):
        update_wrapper(self, function)
        self.function = function

    @cached_property
    def digest(self) -> str:
        """Of what it computes: of its code, and of the numbers and compiled functions that this names."""
        code, names = self.function.__code__, self.function.__globals__
        named = [names[name] for name in code.co_names if name in names and names[name] is not self]
        numbers = [one for one in (*code.co_consts, *named) if isinstance(one, int | float | tuple)]
        called = [one.digest for one in named if isinstance(one, Compiled)]
        return hashlib.sha256(repr((code.co_code, numbers, called)).encode()).hexdigest()[:8]

    @cached_property
    def machine(self) -> Any:
        """The function as numba has it; the machine code is cached where that can be written."""
        from numba import njit  # a third of the time in which a node starts, and some run no loop

        options: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
        self.function.__qualname__ += f"_{self.digest}"  # numba's cache looks at no file but its own
        try:
            return njit(cache=True, **options)(self.function)
        except RuntimeError:  # neither the package's folder nor the user's cache can be written
            return njit(**options)(self.function)

    @property
    def _numba_type_(self) -> Any:
        """What numba asks objects for that compiled code names."""
        return self.machine._numba_type_

    def __call__(self, *arguments: Any) -> Any:
        return self.machine(*arguments)


def compiled(function: Function) -> Function:
    """Compile a loop over time. Division by zero gives inf, as in numpy."""
    return cast(Function, Compiled(function))


@compiled
def copied(values: Array, into: Array) -> None:
    """Copy (n,) within compiled code: a slice that is assigned there takes seconds to compile, for the words
    of what would not fit.
    """
    for k in range(len(values)):
        into[k] = values[k]
