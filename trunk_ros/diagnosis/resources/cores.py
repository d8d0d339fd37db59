"""Independent parts of a diagnosis on several cores. What is found does not depend on how many there are."""

from __future__ import annotations

import gc
import os
import pickle
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from contextvars import ContextVar
from io import StringIO
from itertools import chain, takewhile
from typing import Any, TypeVar

from trunk_ros.diagnosis.resources.work import Work
from trunk_ros.errors import ModelError, fault_in
from trunk_ros.machine import FORKED, NUMBER

try:
    from threadpoolctl import threadpool_limits
except ModuleNotFoundError:  # as where rosdep installed: it has no key for it
    threadpool_limits = None

Item = TypeVar("Item")
Result = TypeVar("Result")
Called = TypeVar("Called", bound=Callable[..., Any])


def one_thread(call: Called) -> Called:
    """A function in which BLAS takes one thread: on matrices as small several wait for each other."""
    return threadpool_limits.wrap(limits=1, user_api="blas")(call) if threadpool_limits else call


class Hands:
    """How many processes may still begin. One that ends gives its place back, so that what is left of the
    longest part is shared as well.
    """

    def __init__(self, more: int):
        self._free, self._back = os.pipe()
        os.set_blocking(self._free, False)
        os.write(self._back, bytes(more))
        self.took: dict[str, float] = {}
        """By kind of part, processor time [s] of one when it was done last."""
        self.owed = 0
        """Places that were given to others and had not come back."""

    def pays(self, kind: str, parts: int) -> bool:
        """Whether half of so many parts takes longer than another process; what is not known may."""
        return parts > 1 and parts * self.took.get(kind, FORKED) >= 2 * FORKED

    def take(self) -> bool:
        """Whether there was a place."""
        try:
            return len(os.read(self._free, 1)) == 1
        except BlockingIOError:
            return False

    def give(self) -> None:
        """A place for another one."""
        if self.owed:
            self.owed -= 1
        else:
            os.write(self._back, bytes(1))

    @contextmanager
    def given(self) -> Iterator[None]:
        """One's own place is another one's meanwhile."""
        self.give()
        try:
            yield
        finally:
            self.owed += not self.take()

    def close(self) -> None:
        """None begins any more."""
        os.close(self._free)
        os.close(self._back)


_hands: ContextVar[Hands | None] = ContextVar("hands", default=None)


@contextmanager
def on_cores(most: int) -> Iterator[None]:
    """Lets what is diagnosed meanwhile use as many."""
    hands = Hands(most - 1) if most > 1 else None
    token = _hands.set(hands)
    try:
        yield
    finally:
        _hands.reset(token)
        if hands is not None:
            hands.close()


def each(work: Work, call: Callable[[Item], Result], items: Sequence[Item]) -> list[Result]:
    """Results of a ``call`` that depends on nothing but its item, in the order of the ``items``; what it
    simulates is counted in ``work``.

    Forked processes take one item after another, as this one does, and share what is within an item as soon
    as one of them has none. What one does not answer, since it was ended from outside, is done here.
    """
    hands = _hands.get()
    if hands is None or len(items) < 2:
        return [call(item) for item in items]
    queue, feed = os.pipe()
    os.write(feed, b"".join(k.to_bytes(NUMBER, "little") for k in range(len(items))))
    os.close(feed)
    children: list[tuple[int, int]] = []
    done: dict[int, Result] = {}
    kind, began = str(getattr(getattr(call, "func", call), "__qualname__", call)), time.process_time()
    try:
        for k in _taken(queue):
            while hands.pays(kind, len(items) - k - len(children)) and hands.take():
                if not (child := _forked(queue, hands, work, call, items)):
                    break
                children.append(child)
            done[k] = call(items[k])
        hands.took[kind] = (time.process_time() - began) / max(len(done), 1)
        with hands.given() if children else nullcontext():
            told = [_answered(answers) for _, answers in children]
        for k, result, simulated in chain.from_iterable(told):
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


def _forked(
    queue: int, hands: Hands, work: Work, call: Callable[[Item], Any], items: Sequence[Item]
) -> tuple[int, int] | None:
    """A process that does items, and where it answers; None where the system grants none."""
    parent, (answers, told) = os.getpid(), os.pipe()
    try:
        number = os.fork()
    except (BlockingIOError, MemoryError):
        os.close(answers)
        os.close(told)
        hands.give()
        return None
    if number:
        os.close(told)
        return number, answers
    try:
        hands.owed = 0
        gc.freeze()  # else a look through all that there is would copy it
        sys.stdout = sys.stderr = StringIO()  # a thread of the parent may have held the locks of its own
        there = takewhile(lambda _: os.getppid() == parent, _taken(queue))
        done = [_outcome(k, work, call, items[k]) for k in there]
        hands.give()
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
