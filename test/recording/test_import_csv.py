"""Tables that others recorded become bags, in SI units and with their own joint names."""

from pathlib import Path

import numpy as np
import pytest

from trunk_ros.commands.import_table import main
from trunk_ros.errors import ArgumentError, RecordingError
from trunk_ros.recording.importing.csv import read_csv
from trunk_ros.recording.importing.mapping import parse_mapping
from trunk_ros.recording.read import read_recording

REAL = Path(__file__).resolve().parents[2].parent / "shared/real"
real = pytest.mark.skipif(not REAL.is_dir(), reason="no shared recordings here")


def position(*columns: object, unit: object = "rad") -> dict[str, object]:
    return {"position": {"columns": list(columns), "unit": unit}}


def mapping(**entries: object):
    content = {"time": {"column": "t", "unit": "s"}, "joints": ["a"], "joint_states": position("x")}
    content.update(entries)
    return parse_mapping({key: value for key, value in content.items() if value is not None})


def table(tmp_path: Path, text: str) -> Path:
    file = tmp_path / "table.csv"
    file.write_text(text)
    return file


def test_units_become_si_and_are_kept_where_they_are_not_rad(tmp_path):
    units = mapping(joints=["a", "b"], joint_states=position("x", "y", unit=["deg", "mm"]))
    recording = read_csv(table(tmp_path, "t,x,y\n0,180,1000\n1,90,500\n"), units)
    np.testing.assert_allclose(recording.require("joint_states").position, [[np.pi, 1], [np.pi / 2, 0.5]])
    assert recording.units == {"b": "m"}
    assert (recording.unit("a"), recording.unit("b")) == ("rad", "m")


def test_a_column_may_be_an_expression(tmp_path):
    recording = read_csv(
        table(tmp_path, "t,x,y\n0,1,2\n1,3,4\n"), mapping(joint_states=position({"expr": "x+y/2"}))
    )
    assert recording.require("joint_states").position.tolist() == [[2.0], [5.0]]


def test_without_a_time_column_the_rate_gives_the_stamps(tmp_path):
    recording = read_csv(table(tmp_path, "x\n1\n2\n3\n"), mapping(time=None, rate_hz=40))
    assert recording.require("joint_states").stamp.tolist() == [0.0, 0.025, 0.05]


def test_of_rows_with_the_same_stamp_the_first_counts_and_the_others_are_counted(tmp_path):
    recording = read_csv(table(tmp_path, "t,x\n0,1\n1,2\n1,3\n1,4\n2,5\n"), mapping())
    assert recording.require("joint_states").position.ravel().tolist() == [1, 2, 5]
    assert "2 rows repeated a stamp: the first of each counts" in recording.notes


def test_a_time_that_never_changes_is_refused_with_its_value(tmp_path):
    """All rows but one were left out, and no joint moved."""
    with pytest.raises(RecordingError, match="the time is 0 s in all 3 rows: is it the right column"):
        read_csv(table(tmp_path, "t,x\n0,1\n0,2\n0,3\n"), mapping())


def test_a_joint_without_a_finite_value_is_refused_and_nothing_else_is_said(tmp_path, recwarn):
    rows = "".join(f"{k / 100},{k % 7}\n" for k in range(200))
    divided = mapping(joint_states=position({"expr": "x/0"}))
    with pytest.raises(RecordingError, match="joint_states has no finite position"):
        read_csv(table(tmp_path, f"t,x\n{rows}"), divided)
    assert not recwarn.list


def test_rows_out_of_order_are_sorted_and_rows_without_time_left_out(tmp_path):
    recording = read_csv(table(tmp_path, "t,x\n2,3\n,9\n0,1\n1,2\n"), mapping())
    assert recording.require("joint_states").position.ravel().tolist() == [1, 2, 3]
    assert {"1 row without a time left out", "1 row out of order, sorted by stamp"} <= set(recording.notes)


def timed(tmp_path: Path, times: np.ndarray) -> Path:
    return table(tmp_path, "t,x\n" + "".join(f"{t!r},{k}\n" for k, t in enumerate(times.tolist())))


def test_runs_one_after_the_other_whose_time_begins_anew_are_refused_with_their_rows(tmp_path):
    first, second = np.arange(0.0, 4.0, 0.01), np.arange(0.5, 3.0, 0.01)
    with pytest.raises(RecordingError) as caught:
        read_csv(timed(tmp_path, np.concatenate([first, second, first])), mapping())
    said = str(caught.value)
    assert "time begins anew at row 401 (3.49 s back), row 651 (2.99 s back)" in said
    assert "Cut the table there, one run per file" in said
    assert "\n" not in said


def test_rows_that_came_late_blocks_that_do_not_overlap_and_merged_streams_are_sorted(tmp_path):
    stamps = np.arange(0.0, 10.0, 0.01)
    late = np.concatenate([stamps[:300], stamps[310:600], stamps[300:310], stamps[600:]])
    exchanged = np.concatenate([stamps[500:], stamps[:500]])
    merged = np.concatenate([np.concatenate([b, b + 0.005]) for b in stamps.reshape(40, 25)])
    for times in (late, exchanged, merged, stamps[::-1]):
        recording = read_csv(timed(tmp_path, times), mapping())
        assert len(recording.require("joint_states").stamp) == len(times)
        assert any("out of order, sorted by stamp" in note for note in recording.notes)


def test_time_may_fall_back_from_topic_to_topic(tmp_path):
    """Each sensor's rows are in order: all of one, and then all of the other."""
    rows = [f"{t!r},1,\n" for t in np.arange(0.0, 4.0, 0.01).tolist()]
    rows += [f"{t!r},,2\n" for t in np.arange(0.005, 4.0, 0.01).tolist()]
    two = mapping(gearbox_states=position("x"), joint_states=position("y"))
    recording = read_csv(table(tmp_path, "t,x,y\n" + "".join(rows)), two)
    assert len(recording.require("joint_states").stamp) == 400


def test_dates_are_times_in_utc_or_of_their_zone(tmp_path):
    rows = [
        "2025-11-12T09:53:06.117Z,1",
        "2025-11-12T10:53:06.217+01:00,2",
        "2025-11-12 09:53:06.317,3",
        ",4",
    ]
    text = "t,x\n" + "\n".join(rows) + "\n"
    recording = read_csv(table(tmp_path, text), mapping(time={"column": "t", "unit": "iso8601"}))
    assert recording.start_ns == pytest.approx(1762941186.117e9, abs=1000)
    np.testing.assert_allclose(recording.require("joint_states").stamp, [0.0, 0.1, 0.2], atol=1e-6)
    with pytest.raises(RecordingError, match=r"line 2: .* wants `unit: iso8601` in the mapping"):
        read_csv(table(tmp_path, text), mapping())
    with pytest.raises(RecordingError, match="line 2: '12' is no date and time in ISO 8601"):
        read_csv(table(tmp_path, "t,x\n12,1\n"), mapping(time={"column": "t", "unit": "iso8601"}))


def test_a_table_without_a_header_is_refused_and_columns_may_be_numbered(tmp_path):
    with pytest.raises(RecordingError, match=r"line 1 holds numbers .*put a line with the names"):
        read_csv(
            table(tmp_path, "0,0.5\n1,0.6\n"), mapping(time={"column": "0"}, joint_states=position("0.5"))
        )
    numbered = mapping(time={"column": "0"}, joint_states=position("1"))
    recording = read_csv(table(tmp_path, "0,1\n0,5\n1,6\n"), numbered)
    assert recording.require("joint_states").position.ravel().tolist() == [5, 6]


def test_a_time_that_begins_below_0_is_moved_and_one_in_the_wrong_unit_refused(tmp_path):
    recording = read_csv(table(tmp_path, "t,x\n-2,1\n-1,2\n"), mapping())
    assert recording.start_ns == 0
    assert any("moved to begin at 0" in note for note in recording.notes)
    with pytest.raises(RecordingError, match="is its unit right"):
        read_csv(table(tmp_path, "t,x\n1750000000000,1\n1750000000010,2\n"), mapping())


def test_empty_fields_and_nan_beside_others_are_masked_and_counted(tmp_path):
    two = mapping(joints=["a", "b"], joint_states=position("x", "y"))
    recording = read_csv(table(tmp_path, "t,x,y\n0,1,0\n1,,0\n2,nan,0\n3,NA,0\n4,2,0\n"), two)
    assert np.isnan(recording.require("joint_states").position).sum() == 3
    assert "joint_states: 3 values not finite, masked" in recording.notes


def test_a_column_without_a_finite_value_is_an_error(tmp_path):
    with pytest.raises(RecordingError, match="joint_states has no finite position of a"):
        read_csv(table(tmp_path, "t,x\n0,\n1,nan\n"), mapping())


def test_a_missing_column_is_named_with_those_that_exist(tmp_path):
    with pytest.raises(RecordingError, match=r"has no column x; there are t, y$"):
        read_csv(table(tmp_path, "t,y\n0,1\n"), mapping())


def test_a_table_with_another_delimiter_says_how_the_mapping_gives_it(tmp_path):
    with pytest.raises(RecordingError, match=r"t;x;y in one: the mapping wants `delimiter: \";\"`$"):
        read_csv(table(tmp_path, "t;x;y\n0;1;2\n"), mapping())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty: a table begins with"),
        ("t,x\n", "has a header and no rows"),
        ("t,x\n0,1\n1,two\n", "line 3: 'two' is not a number"),
        ("t,x\n0,1\n1\n2,3\n", "line 3 has fewer fields"),
        ("t,x\n0,1\n1,2,3\n2,3\n", "line 3 has 3 fields, the header 2"),
        ("t,x\n0,1\n9,1,2\n", "line 3 has 3 fields, the header 2"),
        ("t,x,x\n0,1,2\n", "has several columns x"),
        ("t,x\n0,1" + "1" * 200_000, "is not CSV"),
    ],
)
def test_what_cannot_be_read_is_named_in_one_line(tmp_path, text, said):
    with pytest.raises(RecordingError) as caught:
        read_csv(table(tmp_path, text), mapping())
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_is_not_there_is_said_to_be_not_there(tmp_path):
    with pytest.raises(RecordingError, match=r"nowhere\.csv: does not exist$"):
        main([str(tmp_path / "nowhere.csv"), "--mapping", "dvrk-wrist", "--output", str(tmp_path / "bag")])


def test_a_last_line_that_is_cut_is_left_out_and_said(tmp_path):
    recording = read_csv(table(tmp_path, "t,x\n0,1\n1,2\n2"), mapping())
    assert len(recording.require("joint_states").stamp) == 2
    assert "the last line (4) is cut and left out" in recording.notes


def test_a_table_of_a_spreadsheet_is_read(tmp_path):
    file = tmp_path / "table.csv"
    file.write_bytes("\ufefft ; x\r\n0;1\r\n\r\n1;2\r\n".encode())
    assert read_csv(file, mapping(delimiter=";")).require("joint_states").position.tolist() == [[1.0], [2.0]]


def test_the_command_writes_a_bag_that_keeps_joints_units_and_notes(tmp_path, capsys):
    (tmp_path / "map.yaml").write_text(
        "time: {column: t, unit: s}\njoints: [slide]\njoint_states: {position: {columns: [x], unit: mm}}\n"
    )
    csv = table(tmp_path, "t,x\n5,1\n5,1\n6,2\n")
    arguments = [str(csv), "--mapping", str(tmp_path / "map.yaml"), "--output", str(tmp_path / "bag")]
    assert main(arguments) == 0
    recording = read_recording(tmp_path / "bag")
    assert (recording.joints, recording.units, recording.start_ns) == (("slide",), {"slide": "m"}, 5 * 10**9)
    assert "1 row repeated a stamp: the first of each counts" in recording.notes
    assert "repeated a stamp" in capsys.readouterr().out
    with pytest.raises(ArgumentError, match="exists"):
        main(arguments)
    assert main([*arguments, "--overwrite"]) == 0


def test_arguments_that_are_missing_are_one_line():
    with pytest.raises(ArgumentError, match="--output"):
        main(["x.csv", "--mapping", "dvrk-wrist"])


@real
@pytest.mark.parametrize(
    ("file", "name", "joints", "topics"),
    [
        ("dvrk-wrist/exp1", "dvrk-wrist", 6, {"gearbox_states", "joint_states"}),
        ("tendon-sheath/test0224", "tendon-sheath", 1, {"gearbox_states", "joint_states"}),
        ("tendon-sheath/odd_test", "tendon-sheath", 1, {"gearbox_states", "joint_states"}),
        ("tendon-sheath/sheath_180deg", "tendon-sheath", 1, {"gearbox_states", "joint_states"}),
        ("tendon-sheath/ff", "tendon-sheath-feedforward", 1, {"gearbox_states", "joint_states", "reference"}),
        ("flexible-link/flexarm_K1_6", "flexible-link", 1, {"gearbox_states", "joint_states", "reference"}),
        ("tip-compliance/z-0.105_28", "tip-compliance", 1, {"gearbox_states", "joint_states"}),
    ],
)
def test_the_mappings_fit_the_data_that_they_are_for(file, name, joints, topics):
    recording = read_csv(REAL / f"{file}.csv", name)
    assert set(recording.series) == topics
    assert len(recording.joints) == joints


@real
def test_markers_that_the_camera_lost_are_masked_or_where_it_lost_all_left_out():
    recording = read_csv(REAL / "dvrk-wrist/train_random.csv", "dvrk-wrist")
    lost = np.isnan(recording.require("joint_states").position).sum(axis=0)
    assert lost.tolist() == [0, 0, 0, 67, 67, 67]
    assert "joint_states: 2 rows without a value left out" in recording.notes


@real
def test_the_tip_gives_way_by_what_its_readme_says():
    recording = read_csv(REAL / "tip-compliance/z-0.105_28.csv", "tip-compliance")
    gearbox, tip = recording.require("gearbox_states"), recording.require("joint_states")
    gives_way = tip.position[:, 0] - gearbox.position[:, 0]
    load = -gearbox.effort[:, 0]  # the motors push against it
    assert np.polyfit(load, gives_way, 1)[0] == pytest.approx(0.2e-3, abs=0.02e-3)
    assert recording.units == {"tip_z": "m"}


def test_empty_fields_at_the_end_of_a_line_are_no_columns(tmp_path):
    recording = read_csv(table(tmp_path, "t,x\n0,1,\n1,2, ,\n"), mapping())
    np.testing.assert_array_equal(recording.require("joint_states").position, [[1], [2]])


def swept(tmp_path: Path, times: np.ndarray) -> Path:
    """Smooth motion, a row at each of the times."""
    angle = np.sin(2 * np.pi * np.arange(len(times)) / 400)
    rows = "".join(f"{t!r},{x!r}\n" for t, x in zip(times.tolist(), angle.tolist(), strict=True))
    return table(tmp_path, f"t,x\n{rows}")


@pytest.mark.parametrize(
    ("times", "unit", "said"),
    [
        (
            np.arange(9000) * 10.0,
            "s",
            "a row every 10 s, 25 h in all, and all moves smoothly: is the unit of",
        ),
        (np.arange(9000) * 0.01, "ms", "a row every 1e-05 s, 0.09 s in all: is the unit of the time right?"),
        (np.arange(600) * 0.1, "ms", "a row every 0.0001 s, 0.0599 s in all: is the unit of the time right?"),
        (np.arange(9000) * 0.01, "s", ""),
        (np.arange(9000) * 10.0, "ms", ""),
        (np.arange(200) * 10.0, "s", ""),
    ],
)
def test_a_unit_of_time_that_cannot_be_is_asked_about(times, unit, said, tmp_path):
    notes = read_csv(swept(tmp_path, times), mapping(time={"column": "t", "unit": unit})).notes
    asked = [note for note in notes if "is the unit of the time right" in note]
    assert len(asked) == bool(said)
    assert said in "".join(asked)


def test_joints_faster_than_any_are_asked_about_and_stations_are_not(tmp_path):
    fast = read_csv(
        swept(tmp_path, np.arange(900) * 0.1),
        mapping(time={"column": "t", "unit": "ms"}, joint_states=position({"expr": "10 * x"})),
    )
    rows = "".join(f"{10 * k},{np.random.default_rng(k).uniform(-1, 1)!r}\n" for k in range(600))
    slow = read_csv(table(tmp_path, f"t,x\n{rows}"), mapping())
    assert not [note for note in slow.notes if "is the unit of the time right" in note]
    assert [note for note in fast.notes if "is the unit of the time right" in note]


BLANKS = {"delimiter": " ", "joint_states": position("x")}


@pytest.mark.parametrize(
    "text",
    [
        "  t     x\n  0   1e0\n  0.5   3\n",
        "t\t\tx\n0\t\t1\n0.5\t 3\t\n",
        "# Run 7 of the arm\n#\n# t x\n0 1\n0.5 3\n",
        "% made by a script\n\nt x\n0 1\n0.5 3\n",
    ],
)
def test_a_table_aligned_by_blanks_is_read_below_its_comments(tmp_path, text):
    series = read_csv(table(tmp_path, text), mapping(**BLANKS)).require("joint_states")
    assert series.position.ravel().tolist() == [1.0, 3.0]
    assert series.stamp.tolist() == [0.0, 0.5]
    with pytest.raises(RecordingError, match=r"t.*x in one: the mapping wants `delimiter: \" \"`$"):
        read_csv(table(tmp_path, text), mapping())


def test_comments_above_a_header_are_no_part_of_a_table_and_lines_are_those_of_the_file(tmp_path):
    for head in ("# arm, run 7\nt,x\n", "# arm, run 7\n# t,x\n"):
        recording = read_csv(table(tmp_path, f"{head}0,1\n1,2\n"), mapping())
        assert recording.require("joint_states").position.ravel().tolist() == [1, 2]
        with pytest.raises(RecordingError, match="line 4: 'two' is not a number"):
            read_csv(table(tmp_path, f"{head}0,1\n1,two\n"), mapping())


def test_a_name_that_begins_with_a_mark_of_comments_stays_the_name_of_its_column(tmp_path):
    time = {"column": "%time", "unit": "ns"}
    recording = read_csv(table(tmp_path, "%time,x\n1000000000,1\n3000000000,2\n"), mapping(time=time))
    assert recording.require("joint_states").stamp.tolist() == [0.0, 2.0]


@pytest.mark.parametrize("delimiter", [" ", ",", ";"])
def test_numbers_apart_by_blanks_are_no_header(tmp_path, delimiter):
    with pytest.raises(RecordingError, match=r"line 1 holds numbers .*put a line with the names"):
        read_csv(table(tmp_path, "  0.0  0.5\n  1.0  0.6\n"), mapping(delimiter=delimiter))


def test_a_file_of_arrays_is_pointed_to_where_it_can_be_read(tmp_path):
    np.savez(tmp_path / "run.npz", t=np.arange(3.0))
    for read in (lambda path: read_csv(path, mapping()), read_recording):
        with pytest.raises(RecordingError, match=r"Recording\.from_arrays or from_pandas .*or saved as CSV"):
            read(tmp_path / "run.npz")
