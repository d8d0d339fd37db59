"""A run over many recordings: what is done is not done again, what fails is a row."""

import math
import os
from pathlib import Path

import pytest

pytest.importorskip("pyarrow")
distributed = pytest.importorskip("distributed")

from trunk_ros.fleet.inputs.listing import Job  # noqa: E402
from trunk_ros.fleet.run.cluster import connected, each  # noqa: E402
from trunk_ros.fleet.run.loop import Plan, run  # noqa: E402
from trunk_ros.fleet.run.outcome import FINDINGS, unread  # noqa: E402
from trunk_ros.fleet.run.store import Store, flat  # noqa: E402

FOUND = {
    "stage": "wire", "joint": "joint_1", "effect": "backlash", "parameter": "half_width", "value": 1e-3,
    "std": 1e-5, "unit": "rad", "confidence": 0.9, "word": None, "form": "", "equivalents": [],
}  # fmt: skip


def work(path):
    """As a task would: notes that it was called, and does what the recording says."""
    with open(path + ".calls", "a") as calls:
        calls.write("x")
    said = Path(path).read_text()
    if said == "network":
        raise OSError("no answer")
    if said == "broken":
        return unread("it is damaged"), {}
    return {"reason": "", "cpu": 0.1, "time": 5.0, "findings": [FOUND], "errors": [], "travel": []}, {}


def calls(path):
    return os.path.getsize(path + ".calls") if os.path.exists(path + ".calls") else 0


@pytest.fixture(scope="module")
def client():
    options = {
        "processes": False,
        "n_workers": 1,
        "threads_per_worker": 1,
        "dashboard_address": "127.0.0.1:0",
    }
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as there:
        yield there


@pytest.fixture
def jobs(tmp_path):
    said = {"good": "a", "twin": "a", "broken": "broken", "far": "network"}
    for name, text in said.items():
        (tmp_path / name).write_text(text)
    return [Job("arm", math.nan, str(tmp_path / name)) for name in said] + [
        Job("arm", math.nan, str(tmp_path / "gone"))
    ]


def plan(again=False, setting="model"):
    return Plan(work, lambda job: (job.path,), lambda job: setting, again)


def reasons(table):
    return dict(zip(table["recording"].to_pylist(), table["reason"].to_pylist(), strict=True))


def test_every_recording_is_a_row_and_a_failure_is_its_reason(client, jobs, tmp_path):
    ticks = []
    store = Store(tmp_path / "out", "recordings")
    run(client, jobs, plan(), store, lambda: ticks.append(1))
    told = reasons(store.close())
    assert len(ticks) == len(told) == len(jobs)
    assert told["good"] == told["twin"] == ""
    assert told["broken"] == "it is damaged"
    assert told["far"] == "OSError: no answer"
    assert "does not exist" in told["gone"]
    assert calls(jobs[3].path) == 3, "what the network lost is tried again"


def test_the_same_content_is_diagnosed_once_and_a_second_run_does_nothing(client, jobs, tmp_path):
    good, twin = jobs[:2]
    for _ in range(2):
        store = Store(tmp_path / "out", "recordings")
        run(client, [good], plan(), store)
        run(client, [good, twin], plan(), store)
        table = store.close()
    assert calls(good.path) + calls(twin.path) == 1
    assert table["path"].to_pylist() == [good.path, twin.path]


def test_a_killed_run_leaves_what_was_flushed_and_the_next_goes_on(client, jobs, tmp_path):
    store = Store(tmp_path / "out", "recordings")
    run(client, jobs[:1], plan(), store)
    store.flush()  # and then nothing more: the process is gone
    (tmp_path / "out" / "parts" / "recordings-000099.parquet").write_bytes(b"half of a par")
    again = Store(tmp_path / "out", "recordings")
    run(client, jobs[:3], plan(), again)
    assert set(reasons(again.close())) == {"good", "twin", "broken"}
    assert calls(jobs[0].path) == 1


def test_failures_stay_unless_they_are_to_be_tried_again(client, jobs, tmp_path):
    for again, least in ((False, 1), (False, 1), (True, 2)):
        store = Store(tmp_path / "out", "recordings")
        run(client, [jobs[2]], plan(again), store)
        store.close()
        assert calls(jobs[2].path) == least


def test_another_model_another_arm_and_other_content_are_done_anew(client, jobs, tmp_path):
    store = Store(tmp_path / "out", "recordings")
    good = jobs[0]
    run(client, [good], plan(), store)
    run(client, [good], plan(setting="other"), store)
    assert calls(good.path) == 2
    with open(good.path, "w") as file:
        file.write("b")
    run(client, [good], plan(setting="other"), store)
    assert calls(good.path) == 3
    run(client, [Job("renamed", 7.0, good.path)], plan(setting="other"), store)
    assert calls(good.path) == 3, "a new name of the arm asks for no new diagnosis"
    [row] = store.close().to_pylist()
    assert (row["arm"], row["time"]) == ("renamed", 7.0)


def test_findings_become_rows_with_the_columns_that_others_rely_on(client, jobs, tmp_path):
    store = Store(tmp_path / "out", "recordings")
    run(client, jobs[:3], plan(), store)
    table = flat(store.close(), "findings", FINDINGS)
    assert table.column_names == [
        "arm", "time", "recording", "path", "stage", "joint", "effect", "parameter", "value", "std", "unit",
        "confidence",
    ]  # fmt: skip
    assert table["recording"].to_pylist() == ["good", "twin"]
    assert set(table["time"].to_pylist()) == {5.0}, "the recording's own time, where no list has one"


def profiled(n):
    """What a worker's sampling profiler has kept while it computed."""
    from distributed import get_worker

    sum(k * k for k in range(n))
    worker = get_worker()
    return sum(kept["count"] for _, kept in worker.profile_history) + worker.profile_recent["count"]


def test_a_worker_keeps_nothing_of_what_it_has_done():
    with connected(None, 1) as there:
        assert [r for _, r in each(there, profiled, [(None, (3_000_000,))] * 3)] == [0, 0, 0]
