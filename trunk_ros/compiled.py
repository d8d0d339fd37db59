"""numba's ``njit`` with a type that strict checking understands."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

Function = TypeVar("Function", bound=Callable[..., Any])
Array = NDArray[np.float64]


def compiled(function: Function) -> Function:
    """Compile a loop over time; the machine code is cached where that can be written.

    Division by zero gives inf, as in numpy.
    """
    options: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
    try:
        return cast(Function, njit(cache=True, **options)(function))
    except RuntimeError:  # neither the package's folder nor the user's cache can be written
        return cast(Function, njit(**options)(function))


@compiled
def copied(values: Array, into: Array) -> None:
    """Copy (n,) within compiled code: a slice that is assigned there takes seconds to compile, for the words
    of what would not fit.
    """
    for k in range(len(values)):
        into[k] = values[k]
