"""Several cores give the same answer as one."""

import os
import signal

import numpy as np
import pytest

from test.diagnosis.arms import on, recorded
from trunk_ros.diagnosis.cores import each, on_cores
from trunk_ros.diagnosis.diagnose import diagnose
from trunk_ros.diagnosis.work import Work


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
    def meanwhile(item):
        return np.linalg.svd(np.ones((300, 300)))[1][0] and os.getpid()

    with on_cores(2):
        assert len(set(each(Work(), meanwhile, range(40)))) == 2


def test_an_error_is_raised_as_it_would_be_on_one_core(monkeypatch):
    def fails(item):
        if item == 7:
            raise ValueError("seven")
        return item

    started, fork = [], os.fork
    monkeypatch.setattr(os, "fork", lambda: ((number := fork()) and started.append(number)) or number)
    with on_cores(2), pytest.raises(ValueError, match="seven"):
        each(Work(), fails, range(12))
    assert len(started) == 1
    with pytest.raises(ChildProcessError):  # it was waited for
        os.waitpid(started[0], os.WNOHANG)


def test_what_a_process_that_was_killed_did_not_answer_is_done_again():
    parent = os.getpid()

    def dies_elsewhere(item):
        if os.getpid() != parent:
            os.kill(os.getpid(), signal.SIGKILL)
        return item

    with on_cores(3):
        assert each(Work(), dies_elsewhere, range(30)) == list(range(30))


def test_a_diagnosis_is_the_same_on_two_cores():
    run = recorded({"backlash": {"width": on(2, 2e-3)}}, seconds=20.0)
    one = diagnose([run])
    with on_cores(2):
        two = diagnose([run])
    assert one.to_json() == two.to_json()
