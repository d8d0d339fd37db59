"""Independent parts of a diagnosis on several cores. What is found does not depend on how many there are."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from io import StringIO
from itertools import takewhile
from typing import Any, TypeVar

from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.errors import ModelError, fault_in
from trunk_ros.machine import NUMBER

try:
    from threadpoolctl import threadpool_limits
except ModuleNotFoundError:  # as where rosdep installed: it has no key for it
    threadpool_limits = None

Item = TypeVar("Item")
Result = TypeVar("Result")
Called = TypeVar("Called", bound=Callable[..., Any])


_cores: ContextVar[int] = ContextVar("cores", default=1)


def one_thread(call: Called) -> Called:
    """A function in which BLAS takes one thread: on matrices as small several wait for each other."""
    return threadpool_limits.wrap(limits=1, user_api="blas")(call) if threadpool_limits else call


@contextmanager
def on_cores(most: int) -> Iterator[None]:
    """Lets what is diagnosed meanwhile use as many."""
    token = _cores.set(most)
    try:
        yield
    finally:
        _cores.reset(token)


def each(work: Work, call: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """Results of a ``call`` that depends on nothing but its item, in the order of the ``items``; what it
    simulates is counted in ``work``.

    Forked processes take one item after another, as this one does. What one of them does not answer, since
    it was ended from outside, is done here.
    """
    hands = min(_cores.get(), len(items))
    if hands < 2:
        return [call(item) for item in items]
    queue, feed = os.pipe()
    os.write(feed, b"".join(k.to_bytes(NUMBER, "little") for k in range(len(items))))
    os.close(feed)
    children: list[tuple[int, int]] = []
    try:
        for _ in range(hands - 1):
            with suppress(BlockingIOError, MemoryError):  # as many as the system grants
                children.append(_forked(queue, work, call, items))
        with on_cores(1):  # all are taken
            done = {k: call(items[k]) for k in _taken(queue)}
        for _, answers in children:
            for k, result, simulated in _answered(answers):
                if isinstance(result, BaseException):
                    raise result
                done[k] = result
                work.done += simulated
    finally:
        os.close(queue)
        for number, answers in children:
            os.close(answers)
            with suppress(ProcessLookupError, ChildProcessError):
                os.kill(number, signal.SIGKILL)
                os.waitpid(number, 0)
    return [done[k] if k in done else call(items[k]) for k in range(len(items))]


def _taken(queue: int) -> Iterator[int]:
    """Numbers of items that nobody has taken yet."""
    while len(number := os.read(queue, NUMBER)) == NUMBER:
        yield int.from_bytes(number, "little")


def _forked(queue: int, work: Work, call: Callable[[Item], Any], items: Sequence[Item]) -> tuple[int, int]:
    """A process that does items, and where it answers."""
    parent, (answers, told) = os.getpid(), os.pipe()
    try:
        number = os.fork()
    except OSError:
        os.close(answers)
        os.close(told)
        raise
    if number:
        os.close(told)
        return number, answers
    try:
        _cores.set(1)
        sys.stdout = sys.stderr = StringIO()  # a thread of the parent may have held the locks of its own
        there = takewhile(lambda _: os.getppid() == parent, _taken(queue))
        done = [_outcome(k, work, call, items[k]) for k in there]
        with os.fdopen(told, "wb") as stream:
            pickle.dump(done, stream)
    finally:
        os._exit(0)  # nothing of the parent's is flushed or closed twice


def _outcome(k: int, work: Work, call: Callable[[Item], Any], item: Item) -> tuple[int, Any, int]:
    before = work.done
    try:
        return k, call(item), work.done - before
    except Exception as error:
        said = fault_in(error)  # which the error does not carry from process to process
        return k, error if said is None else ModelError(said), 0


def _answered(answers: int) -> list[tuple[int, Any, int]]:
    """What a process has told, nothing if it ended before."""
    with os.fdopen(os.dup(answers), "rb") as stream:
        told = stream.read()
    try:
        return list(pickle.loads(told))
    except (
        Exception
    ):  # cut off, or an error that does not unpickle: it comes again where the item is done here
        return []
