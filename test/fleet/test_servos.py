"""The servos of an arm are found once: what wears later is not its nominal."""

import json
from dataclasses import replace

import pytest

pq = pytest.importorskip("pyarrow.parquet")
pytest.importorskip("distributed")
pytest.importorskip("ruptures")

from test.diagnosis.arms import of_joints  # noqa: E402
from test.diagnosis.test_nominal_servo import OWN, recorded_servos  # noqa: E402
from trunk_ros.__main__ import main  # noqa: E402
from trunk_ros.arm.arm import SERVO_OF_EACH  # noqa: E402
from trunk_ros.diagnosis.servos.nominal_servo import Servos  # noqa: E402
from trunk_ros.fleet.inputs.listing import Job  # noqa: E402
from trunk_ros.fleet.run import servos as of_arms  # noqa: E402
from trunk_ros.fleet.together.series import DAY  # noqa: E402
from trunk_ros.model import load_model  # noqa: E402
from trunk_ros.recording.write import write_recording  # noqa: E402

pytestmark = pytest.mark.timeout(600)


def test_a_servo_that_gets_slower_is_followed_from_what_it_was(tmp_path):
    for k, gain in enumerate((12.0, 12.0, 12.0, 10.8, 9.6)):
        servos = OWN | {"kp": (gain, *OWN["kp"][1:])}
        recording = of_joints(recorded_servos(servos, seed=k, seconds=6.0), "shoulder", "elbow")
        write_recording(
            tmp_path / "arm" / f"day_{k}", replace(recording, start_ns=int((k + 1) * DAY) * 10**9)
        )
    there = tmp_path / "out"
    asked = ["fleet", str(tmp_path / "arm"), "--model", "direct", "--output", str(there), "--workers", "1"]
    assert main(asked) == 0
    (own,) = json.loads((there / "servos.json").read_text())["arms"].values()
    assert own["numbers"]["shoulder"][0] == pytest.approx(12.0, rel=0.01)
    found = [
        (f["recording"], f["effect"], f["joint"])
        for f in pq.read_table(there / "findings.parquet").to_pylist()
    ]
    assert sorted(found) == [(f"day_{k}", "servo_bandwidth", "shoulder") for k in (3, 4)]
    values = pq.read_table(there / "values.parquet").to_pylist()
    followed = {
        v["recording"]: v["value"]
        for v in values
        if v["effect"] == "servo_bandwidth" and v["joint"] == "shoulder"
    }
    assert [followed[f"day_{k}"] for k in range(5)] == pytest.approx([0.0, 0.0, 0.0, -0.1, -0.2], abs=5e-3)
    assert main(asked) == 0, "its own output is none of another's"


def test_servos_that_were_found_stay_where_the_run_is_stopped(tmp_path, monkeypatch):
    found = Servos({"elbow": (12.0,) * len(SERVO_OF_EACH)}, "held")

    def stopped(client, work, tasks):
        yield tasks[0][0], found
        raise KeyboardInterrupt

    jobs = [Job(arm, 0.0, f"{arm}/run") for arm in ("left", "right")]
    monkeypatch.setattr(of_arms, "each", stopped)
    with pytest.raises(KeyboardInterrupt):
        of_arms.servos(None, tmp_path / "out", jobs, load_model("direct"))
    monkeypatch.setattr(of_arms, "each", lambda client, work, tasks: [(arm, None) for arm, _ in tasks])
    assert of_arms.servos(None, tmp_path / "out", jobs, load_model("direct")) == {"left": found}
