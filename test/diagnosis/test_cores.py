"""Several cores give the same answer as one."""

import os
import signal
import sys
import time

import pytest

from test.diagnosis.arms import PAIR, on, recorded
from trunk_ros.diagnosis.diagnose import diagnose
from trunk_ros.diagnosis.resources import cores
from trunk_ros.diagnosis.resources.cores import each, on_cores
from trunk_ros.diagnosis.resources.work import Work


def test_results_come_in_the_order_of_the_items_and_their_work_is_counted():
    work = Work()

    def squared(item):
        work.done += item
        return item**2, os.getpid()

    with on_cores(3):
        found = each(work, squared, range(200))
    assert [square for square, _ in found] == [item**2 for item in range(200)]
    assert work.done == sum(range(200))
    assert {number for _, number in each(Work(), squared, range(20))} == {os.getpid()}


def test_the_work_is_shared():
    parent, (heard, told) = os.getpid(), os.pipe()

    def done_by(item):
        if os.getpid() == parent:
            os.read(heard, 1)  # until the other has taken one more
        else:
            os.write(told, b".")
        return os.getpid()

    with on_cores(2):
        assert set(each(Work(), done_by, range(40))) - {parent}
    os.close(heard)
    os.close(told)


def test_who_has_nothing_left_to_do_helps_within_the_longest_part():
    parent, (heard, told) = os.getpid(), os.pipe()

    def within(item):
        if os.getpid() == parent:
            os.read(heard, 1)  # until the other has taken one more
        else:
            os.write(told, b".")
        return os.getpid()

    def long_at_first(item):
        if item == 1:
            return {parent}
        hands = cores._hands.get()
        while not hands.take():  # the other has not ended as yet
            time.sleep(0.01)
        hands.give()
        return {*each(Work(), within, range(4))}

    with on_cores(2):
        both, other = each(Work(), long_at_first, range(2))
    assert len(both) == 2
    assert other == {parent}
    os.close(heard)
    os.close(told)


def test_parts_that_take_less_than_a_process_stay_where_they_are():
    with on_cores(2):
        for known in (False, True):
            found = each(Work(), lambda _: os.getpid(), range(2))
            assert not known or set(found) == {os.getpid()}


def test_an_error_is_raised_as_it_would_be_on_one_core(monkeypatch):
    def fails(item):
        if item == 7:
            raise ValueError("seven")
        return item

    started, fork = [], os.fork
    monkeypatch.setattr(os, "fork", lambda: ((number := fork()) and started.append(number)) or number)
    with on_cores(2), pytest.raises(ValueError, match="seven"):
        each(Work(), fails, range(12))
    assert started
    for number in started:
        with pytest.raises(ChildProcessError):  # it was waited for
            os.waitpid(number, os.WNOHANG)


def test_what_a_process_that_was_killed_did_not_answer_is_done_again():
    parent = os.getpid()

    def dies_elsewhere(item):
        if os.getpid() != parent:
            os.kill(os.getpid(), signal.SIGKILL)
        return item

    with on_cores(3):
        assert each(Work(), dies_elsewhere, range(30)) == list(range(30))


def test_a_diagnosis_is_the_same_on_two_cores():
    run = recorded({"backlash": {"half_width": on(2, 2e-3, joints=2)}}, seconds=10.0, nominal=PAIR)
    one = diagnose([run], PAIR)
    with on_cores(2):
        two = diagnose([run], PAIR)
    assert [f.effect for f in one.findings] == ["backlash"]
    assert one.to_json() == two.to_json()


def test_a_diagnosis_takes_one_thread_of_blas(monkeypatch):
    pools = pytest.importorskip("threadpoolctl")
    seen = []

    def looked(*_, **__):
        seen.extend(pool["num_threads"] for pool in pools.threadpool_info() if pool["user_api"] == "blas")
        raise InterruptedError

    monkeypatch.setattr(sys.modules["trunk_ros.diagnosis.diagnose"], "put_right", looked)
    with pools.threadpool_limits(2, "blas"), pytest.raises(InterruptedError):
        diagnose([recorded({}, seconds=5.0)])
    assert set(seen) == {1}
