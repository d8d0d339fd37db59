"""numba's ``njit`` with a type that strict checking understands."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

Function = TypeVar("Function", bound=Callable[..., Any])
Array = NDArray[np.float64]


def compiled(function: Function) -> Function:
    """Compile a loop over time; the machine code is cached beside the source.

    Division by zero gives inf, as in numpy.
    """
    return cast(Function, njit(cache=True, nogil=True, error_model="numpy")(function))
