"""The process that diagnoses: it is told where the first recording lies and where to write, and nothing else.

It has neither the answer nor its key in memory, and cannot open what else belongs to the proof.
"""

from __future__ import annotations

import contextlib
import ctypes
import io
import multiprocessing
import os
import signal
import sys
import time
import traceback
from dataclasses import dataclass
from functools import cache
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

WITH_THE_PARENT = 1  # PR_SET_PDEATHSIG
OPENS = ("open", "os.listdir", "os.scandir", "os.link", "os.symlink", "os.rename")


class ForbiddenError(Exception):
    """Something was opened that the diagnosis may not see."""


@dataclass(frozen=True)
class Said:
    """How a diagnosis ended: s that it took; what went wrong, empty where nothing did."""

    seconds: float
    failed: str = ""


@dataclass
class _Walls:
    """What may not be opened: all of ``shut`` but for what is in ``free``."""

    shut: Path | None = None
    free: tuple[Path, ...] = ()

    def check(self, event: str, arguments: tuple[Any, ...]) -> None:
        if self.shut is None or event not in OPENS or not isinstance(arguments[0], (str, bytes, os.PathLike)):
            return
        path = Path(os.path.realpath(os.fsdecode(arguments[0])))
        if path.is_relative_to(self.shut) and not any(path.is_relative_to(some) for some in self.free):
            raise ForbiddenError(f"{path.name} was opened during the diagnosis")


def command(*arguments: Any) -> None:
    """A command of the package in this process. Raises RuntimeError with its last words."""
    from trunk_ros.__main__ import main as run

    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()) as err:
        status = run([str(x) for x in arguments])
    if status:
        raise RuntimeError(f"{arguments[0]} ended with {status}: {err.getvalue().strip()[-400:]}")


def _serve(pipe: Connection) -> None:
    """Diagnoses what comes through the pipe until it closes."""
    ctypes.CDLL(None).prctl(WITH_THE_PARENT, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends this
    walls = _Walls()
    sys.addaudithook(walls.check)
    with contextlib.suppress(EOFError):
        while True:
            shut, bag, out = pipe.recv()
            began = time.perf_counter()
            try:
                walls.free, walls.shut = (bag, out.parent), shut
                command("diagnose", bag, "--output", out)
                said = Said(time.perf_counter() - began)
            except Exception as error:  # whatever the diagnosis does, the proof goes on
                said = Said(0.0, f"{error}\n{traceback.format_exc()[-1200:]}")
            walls.shut = None
            pipe.send(said)


@cache
def _solver() -> Connection:
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    context.Process(target=_serve, args=(there,), daemon=True).start()
    there.close()
    return here


def diagnosed(shut: Path, bag: Path, out: Path) -> Said:
    """Diagnoses a bag in the other process, to which all in ``shut`` is closed but the bag and out's
    folder.
    """
    pipe = _solver()
    pipe.send(tuple(Path(os.path.realpath(path)) for path in (shut, bag, out)))
    try:
        said: Said = pipe.recv()
    except EOFError:
        _solver.cache_clear()  # the next case gets a new one
        return Said(0.0, "the process of the diagnosis ended")
    return said
