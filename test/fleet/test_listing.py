"""What the arguments of ``fleet`` name."""

import math

import pytest

from trunk_ros.errors import ArgumentError
from trunk_ros.fleet.inputs.files import fingerprint, here
from trunk_ros.fleet.inputs.listing import listed
from trunk_ros.fleet.inputs.table import seconds_of


def bag(path, content=b"x"):
    path.mkdir(parents=True)
    (path / "metadata.yaml").write_text("rosbag2_bagfile_information: {}")
    (path / "run_0.mcap").write_bytes(content)
    return path


def test_a_folder_gives_the_bags_below_it_each_of_the_arm_whose_folder_it_is_in(tmp_path):
    bag(tmp_path / "left" / "monday")
    bag(tmp_path / "right" / "monday")
    (tmp_path / "right" / "bare.mcap").write_bytes(b"y")
    (tmp_path / "right" / "notes.txt").write_text("no recording")
    jobs = listed([str(tmp_path)])
    assert [(job.arm, job.recording) for job in jobs] == [
        ("left", "monday"), ("right", "bare.mcap"), ("right", "monday")
    ]  # fmt: skip
    assert all(math.isnan(job.time) for job in jobs)


def test_a_glob_and_a_bag_named_twice_give_each_bag_once(tmp_path):
    one, two = bag(tmp_path / "arm" / "a"), bag(tmp_path / "arm" / "b")
    jobs = listed([str(tmp_path / "arm" / "*"), str(one)])
    assert [job.path for job in jobs] == [str(one), str(two)]


@pytest.mark.parametrize("name", ["list.csv", "list.parquet"])
def test_a_list_gives_arm_and_time_and_paths_from_its_own_folder(tmp_path, name):
    pa = pytest.importorskip("pyarrow")
    rows = [
        ("seven", "2026-01-02T00:00:00Z", "bags/a"),
        ("seven", "90.5", "s3://bucket/b"),
        ("eight", "", "/c"),
    ]
    if name.endswith("csv"):
        lines = ["arm,time,path,note", *(f"{arm},{time},{path},n" for arm, time, path in rows)]
        (tmp_path / name).write_text("\n".join(lines))
    else:
        import pyarrow.parquet as pq

        columns = dict(zip(("arm", "time", "path"), map(list, zip(*rows, strict=True)), strict=True))
        pq.write_table(pa.table(columns), tmp_path / name)
    jobs = listed([str(tmp_path / name)])
    assert [job.path for job in jobs] == [f"{tmp_path}/bags/a", "s3://bucket/b", "/c"]
    assert [job.arm for job in jobs] == ["seven", "seven", "eight"]
    assert (jobs[0].time, jobs[1].time) == (1767312000.0, 90.5)
    assert math.isnan(jobs[2].time)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("arm,when,path\na,1,b\n", "no column time"),
        ("arm,time,path\na,yesterday,b\n", "row 2: 'yesterday' is no time"),
        ("arm,time,path\na,1,b\n,1,c\n", "row 3: arm and path must not be empty"),
    ],
)
def test_what_is_wrong_with_a_list_is_said_with_its_row(tmp_path, content, said):
    (tmp_path / "list.csv").write_text(content)
    with pytest.raises(ArgumentError, match=said):
        listed([str(tmp_path / "list.csv")])


def test_a_place_without_recordings_and_an_unknown_protocol_are_refused(tmp_path):
    with pytest.raises(ArgumentError, match="no recording there"):
        listed([str(tmp_path)])
    with pytest.raises(ArgumentError, match="does not exist"):
        listed([str(tmp_path / "nothing")])
    with pytest.raises(ArgumentError, match="nowhere"):
        listed(["nowhere://bucket/bag"])


def test_a_recording_behind_a_url_is_copied_for_as_long_as_it_is_needed():
    fsspec = pytest.importorskip("fsspec")
    memory = fsspec.filesystem("memory")
    memory.pipe("/fleet/arm/run/metadata.yaml", b"content")
    [job] = listed(["memory://fleet"])
    assert (job.arm, job.recording) == ("arm", "run")
    with here(job.path) as local:
        assert (local / "metadata.yaml").read_bytes() == b"content"
    assert not local.exists()
    memory.rm("/fleet", recursive=True)


def test_a_fingerprint_is_that_of_the_content_wherever_it_lies(tmp_path):
    one, two = bag(tmp_path / "a" / "run"), bag(tmp_path / "b" / "again")
    other = bag(tmp_path / "c" / "run", b"z")
    assert fingerprint(str(one)) == fingerprint(str(two)) != fingerprint(str(other))


def test_times_are_seconds_or_iso_8601_in_utc():
    assert seconds_of("1970-01-02", "") == seconds_of("1970-01-02T02:00:00+02:00", "") == 86400.0
