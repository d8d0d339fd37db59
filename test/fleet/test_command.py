"""The command, from bags to the page."""

import json
from dataclasses import replace

import numpy as np
import pytest

pq = pytest.importorskip("pyarrow.parquet")
pytest.importorskip("distributed")
pytest.importorskip("ruptures")

from test.diagnosis.arms import PAIR, of_the_wires, on, recorded  # noqa: E402
from trunk_ros.__main__ import main  # noqa: E402
from trunk_ros.commands.fleet import _say  # noqa: E402
from trunk_ros.fleet.inputs.listing import listed  # noqa: E402
from trunk_ros.fleet.report.page import render  # noqa: E402
from trunk_ros.fleet.run.follow import follow  # noqa: E402
from trunk_ros.fleet.together.events import alone  # noqa: E402
from trunk_ros.fleet.together.series import DAY  # noqa: E402
from trunk_ros.fleet.together.summary import Fleet, Trend  # noqa: E402
from trunk_ros.model import save_model  # noqa: E402
from trunk_ros.recording.write import write_recording  # noqa: E402

pytestmark = pytest.mark.timeout(600)


def written(folder, effects, seed, day=0):
    recording = of_the_wires(recorded(effects, seconds=8.0, seed=seed, nominal=PAIR))
    write_recording(folder, replace(recording, start_ns=recording.start_ns + int(day * DAY) * 10**9))
    return folder


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    """One arm whose dead band grows over five days, and a bag that is none."""
    folder = tmp_path_factory.mktemp("bags") / "<arm>"
    for k in range(5):
        width = on(2, 4e-4 + 4e-4 * k, 2)
        written(folder / f"day_{k}", {"backlash": {"half_width": width}}, seed=k, day=k)
    (folder / "broken").mkdir()
    (folder / "broken" / "metadata.yaml").write_text("no: [yaml")
    return folder


@pytest.fixture(scope="module")
def output(bags, tmp_path_factory):
    """What the command makes of them."""
    there = tmp_path_factory.mktemp("out") / "fleet"
    save_model(PAIR, there.parent / "model.yaml")
    assert main(["fleet", str(bags), "--output", str(there), *how(there)]) == 0
    return there


def how(output):
    """The other words of the command."""
    return "--model", str(output.parent / "model.yaml"), "--workers", "1"


def test_a_growing_dead_band_is_a_trend_and_a_broken_bag_a_reason(output):
    told = json.loads((output / "fleet.json").read_text())
    assert told["schema"] == "trunk_ros/fleet/1"
    arm = told["arms"]["<arm>"]
    days = [t for t in arm["trends"] if t["per"] == "day"]
    assert [(t["effect"], t["joint"], t["parameter"]) for t in days] == [
        ("backlash", "joint_2", "half_width")
    ]
    assert days[0]["interval"][0] < 4e-4 < days[0]["interval"][1]
    assert [t["per"] for t in arm["trends"]] == ["day", "m"]
    [unread] = told["unread"]
    assert "damaged metadata.yaml" in unread["reason"]


def test_the_tables_have_the_columns_that_others_rely_on(output):
    findings = pq.read_table(output / "findings.parquet")
    errors = pq.read_table(output / "errors.parquet")
    assert findings.column_names == (
        [
            "arm",
            "time",
            "recording",
            "path",
            "stage",
            "joint",
            "effect",
            "parameter",
            "value",
            "std",
            "unit",
            "confidence",
        ]
    )
    assert errors.column_names == (
        [
            "arm",
            "time",
            "recording",
            "path",
            "stage",
            "joint",
            "unit",
            "rmse_before",
            "rmse_after",
            "noise_floor",
            "verdict",
        ]
    )
    assert set(findings["recording"].to_pylist()) == {f"day_{k}" for k in range(5)}


def test_the_page_needs_no_other_file_and_shows_what_names_are_not_markup(output):
    page = (output / "fleet.html").read_text()
    assert "&lt;arm&gt;" in page
    assert "<arm>" not in page
    assert "http" not in page.replace("http://www.w3.org", "")
    links = [part.split('"')[0] for part in page.split('href="')[1:]]
    assert links
    assert all((output / link).exists() for link in links)


def test_a_second_run_diagnoses_nothing_again(output, bags, monkeypatch):
    before = (output / "fleet.json").read_text()
    cpu = pq.read_table(output / "recordings.parquet")["cpu"].to_pylist()
    assert main(["fleet", str(bags), "--output", str(output), *how(output)]) == 0
    assert pq.read_table(output / "recordings.parquet")["cpu"].to_pylist() == cpu
    assert (output / "fleet.json").read_text() == before


def test_an_effect_is_followed_to_where_it_is_too_small_to_be_found(tmp_path):
    bag = written(tmp_path / "bag", {}, seed=3)
    row, _ = follow(str(bag), PAIR, {"backlash": {"half_width": {"joint_2": 5e-4}}})
    assert row["reason"] == ""
    [value] = row["findings"]
    assert (value["effect"], value["joint"]) == ("backlash", "joint_2")
    assert abs(value["value"]) < 5 * value["std"] < 1e-4


def test_a_folder_of_other_things_and_a_wrong_limit_are_refused(tmp_path, bags, capsys):
    (tmp_path / "thesis.tex").write_text("")
    assert main(["fleet", str(bags), "--output", str(tmp_path)]) == 2
    assert "holds other things too (thesis.tex)" in capsys.readouterr().err
    assert main(["fleet", str(bags), "--output", str(tmp_path / "x"), "--limit", "backlash.width=3"]) == 2
    assert "backlash has no parameter 'width'" in capsys.readouterr().err
    assert main(["fleet", str(bags), "--output", str(tmp_path / "x"), "--workers", "0"]) == 2
    assert "--workers: 0: give a whole number from 1 on" in capsys.readouterr().err


def test_a_fleet_of_which_nothing_can_be_read_says_so(tmp_path, capsys):
    (tmp_path / "list.csv").write_text("arm,time,path\na,0,missing\n")
    assert main(["fleet", str(tmp_path / "list.csv"), "--output", str(tmp_path / "o"), "--workers", "1"]) == 2
    assert "none of 1 recordings" in capsys.readouterr().err
    assert "does not exist" in (tmp_path / "o" / "fleet.json").read_text()


def test_a_missing_path_is_named_once(tmp_path, bags, capsys):
    gone = tmp_path / "gone"
    assert main(["fleet", str(gone), "--output", str(tmp_path / "o")]) == 2
    assert capsys.readouterr().err.count(str(gone)) == 1
    told = {"arms": {}, "common": [], "unread": [{"path": str(gone), "reason": f"{gone}: does not exist"}]}
    _say(told, 1, tmp_path / "o")
    assert f"not read: {gone}: does not exist\n" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("crosses", "said"),
    [
        ((1e9, 0.9e9, None), "; it reaches 0.002 rad on 2001-09-09 (1998-07-09 to never)"),
        ((None, None, None), "; it never reaches 0.002 rad"),
    ],
)
def test_the_last_lines_say_when_a_trend_reaches_its_limit(crosses, said, tmp_path, capsys):
    key = ("a", "backlash", "joint_2", "half_width")
    trend = Trend(*key, 1e-6, (5e-7, 2e-6), "rad", "day", 0.0, 1e-4, 1e-9, 2e-3, crosses)
    _say(Fleet({"a": 5}, [], [trend], [], [], []).to_json(), 5, tmp_path)
    assert said in capsys.readouterr().out


def test_an_empty_fleet_has_a_page(tmp_path):
    from trunk_ros.fleet.together.summary import Fleet

    page = render(Fleet({"a": 5}, [], [], [], [], []), {}, "model")
    assert "No effect was found" in page
    assert np.all([word in page for word in ("Nothing grows", "No jump")])


def test_arms_with_few_recordings_get_no_clean_bill_but_what_was_found_and_their_report(tmp_path, capsys):
    rows = [
        {"arm": "left", "effect": "joint_coupling", "joint": "elbow", "path": path, "parameter": one}
        for path in ("a", "b")
        for one in ("gain", "source")
    ]
    fleet = Fleet({"left": 2, "right": 1}, [], [], [], [], [], alone=alone(rows))
    page = render(fleet, {"left": "arms/left/report.html"}, "model")
    assert "2 arms, 3 recordings: effects found on 1, too few recordings of 2 to judge what grows" in page
    assert '<a href="arms/left/report.html">left</a>' in page
    assert "joint coupling on elbow (2)" in page
    assert not any(
        word in page for word in ("Nothing grows", "nothing grows", "No jump", "No effect", "No arm")
    )
    _say(fleet.to_json(), 1, tmp_path)
    said = capsys.readouterr().out
    assert "1 recording of 2 arms" in said
    assert "2 arms with fewer than 5 recordings: what grows there is not judged" in said


def test_bags_are_listed_by_arm(bags):
    assert {job.arm for job in listed([str(bags.parent)])} == {"<arm>"}
