"""The commands that README and the pages show end as a reader expects, page by page, from a folder with a
reader's own files: two runs of an arm, its model, URDF, tables, and a run of a simulator.
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from test.diagnosis.arms import of_the_wires, on, recorded
from test.test_docs import DOCS, PAGES, ROOT, fenced
from trunk_ros.__main__ import COMMANDS, main
from trunk_ros.arm.urdf import urdf
from trunk_ros.chain import Chain
from trunk_ros.compiled import Array
from trunk_ros.model import Model, load_model, save_model
from trunk_ros.recording.recording import JointSeries, Recording
from trunk_ros.recording.write import write_recording

HALF_WIDTH = 4e-3  # rad, of the elbow
ELSEWHERE = {
    "docs/simulators.md": ("test/export/test_command.py", "test/export/test_page.py"),
    "docs/fleet.md": ("test/fleet/test_command.py",),
    "docs/adding-an-effect.md": ("test/effects/test_adding_an_effect.py",),
    "docs/real.md": tuple(  # with the published data, where they are
        f"test/diagnosis/{name}.py" for name in ("test_real", "test_real_sheath", "test_real_links")
    ),
}
"""Pages whose commands need a simulator, many arms, an own effect or published data: run by these tests."""
NODES = {name for name, (module, *_) in COMMANDS.items() if module.startswith("trunk_ros.nodes")}
RUN = [
    "README.md",
    "docs/own-arm.md",
    "docs/commands.md",
    "docs/paper.md",
    "docs/recording.md",
]

WITHIN = {"docs/index.md": "README.md"}
"""Pages whose commands are some of another page's, in its order."""

SEVERAL = ("docs/own-arm.md", "docs/recording.md")
"""Pages with several ways to one output, which in one folder would meet."""


def commands(page: str) -> list[list[str]]:
    """What a page shows of trunk_ros, besides nodes."""
    shown = re.findall(r"^ *(?:\$ )?trunk_ros ([^#\n]*)", fenced(ROOT / page), re.MULTILINE)
    words = [shlex.split(line) for line in shown]
    return [each for each in words if each[0] not in NODES]


def run(arm: Model, seed: int, ideal: bool = False) -> Recording:
    """8 s of an arm with backlash on its elbow, or of the arm as it should be."""
    t = np.arange(0.0, 8.0, 0.01)
    rng = np.random.default_rng(seed)
    rates, phases = rng.uniform(0.1, 0.6, (3, 3)), rng.uniform(0.0, 6.0, (3, 3))
    motor = 0.3 * np.sin(2.0 * np.pi * t[:, None, None] * rates + phases).sum(axis=1)
    effects = {} if ideal else {"backlash": {"half_width": np.array([0.0, HALF_WIDTH, 0.0])}}
    joint = Chain(Model(arm.arm, effects), "wire").run(motor, t)[0] + rng.normal(0.0, 1e-4, motor.shape)
    series = {
        "gearbox_states": JointSeries(t, arm.arm.joints, motor),
        "joint_states": JointSeries(t, arm.arm.joints, joint),
    }
    return Recording(f"run{seed}", 1_750_000_000_000_000_000, float(t[-1]), series)


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with what the pages take for granted."""
    own_arm = (DOCS / "own-arm.md").read_text(encoding="utf-8")
    for name, text in re.findall(r"```yaml\n# (\S+)\n(.*?)```", own_arm, re.DOTALL):
        (tmp_path / name).write_text(text)
    arm = load_model(tmp_path / "my-arm.yaml")
    first = run(arm, 1)
    for name in ("run1", "run"):
        write_recording(tmp_path / name, first)
    (tmp_path / "demo-output").mkdir()
    write_recording(
        tmp_path / "demo-output" / "run_1",
        of_the_wires(recorded({"backlash": {"half_width": on(2, 5e-3)}}, 10.0)),
    )
    write_recording(tmp_path / "run2", run(arm, 2))
    write_recording(tmp_path / "decisive", run(arm, 3))
    write_recording(tmp_path / "sim1", run(arm, 1, ideal=True))
    (tmp_path / "my_arm.urdf").write_text(urdf(arm.arm))
    a_table(tmp_path / "run1.csv", first)
    for name in ("old_bag", "OLD_BAG"):
        an_old_bag(tmp_path / name, first)
    (tmp_path / "map.yaml").write_text((tmp_path / "my-bag-map.yaml").read_text())
    monkeypatch.chdir(tmp_path)
    return tmp_path


def a_table(path: Path, recording: Recording) -> None:
    """The columns of own-arm.md's mapping."""
    motor, joint = (recording.series[key].position for key in ("gearbox_states", "joint_states"))
    stamp = 1e3 * recording.series["joint_states"].stamp
    degrees = np.degrees(motor)
    still = np.zeros(len(stamp))
    columns = [stamp, degrees[:, 0], degrees[:, 1], still, still, joint[:, 0], np.degrees(joint[:, 1]) + 90.0]
    head = "t_ms,m1_deg,m2_deg,i1,i2,enc1,enc2"
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=head, comments="", fmt="%.9g")


def an_old_bag(path: Path, recording: Recording) -> None:
    """The topics of own-arm.md's mapping of a bag."""
    store = get_typestore(Stores.ROS2_JAZZY)
    make = store.types
    states, number = "sensor_msgs/msg/JointState", "std_msgs/msg/Float64"
    topics = {"/motor_1/state": states, "/motor_2/state": states, "/encoders": states, "/elbow_angle": number}
    none = np.empty(0)

    def state(ns: int, name: str, angle: float) -> bytes:
        head = make["std_msgs/msg/Header"](make["builtin_interfaces/msg/Time"](*divmod(ns, 10**9)), "")
        return bytes(store.serialize_cdr(make[states](head, [name], np.array([angle]), none, none), states))

    motor, joint = (recording.series[key].position for key in ("gearbox_states", "joint_states"))
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        channels = {name: bag.add_connection(name, kind, typestore=store) for name, kind in topics.items()}
        for row, stamp in enumerate(recording.series["joint_states"].stamp):
            ns = recording.start_ns + round(stamp * 1e9)
            turned: Array = np.degrees(joint[row])
            bag.write(channels["/motor_1/state"], ns, state(ns, "m", motor[row, 0]))
            bag.write(channels["/motor_2/state"], ns, state(ns, "m", motor[row, 1]))
            bag.write(channels["/encoders"], ns, state(ns, "left", turned[0]))
            angle = make[number](float(turned[1]) + 90.0)
            bag.write(channels["/elbow_angle"], ns, bytes(store.serialize_cdr(angle, number)))


@pytest.mark.parametrize("page", RUN)
def test_the_commands_of_a_page_end_as_they_should(
    page: str, files: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    if page == "docs/commands.md":
        pytest.importorskip("rerun")
        monkeypatch.setattr("sys.platform", "linux")
        monkeypatch.delenv("DISPLAY", raising=False)
        monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
        save_model(load_model("my-arm.yaml"), "verdict.yaml")
        (files / "verdict").mkdir()
        (files / "verdict.yaml").rename(files / "verdict" / "model.yaml")
    done = 0
    for words in commands(page):
        if page in SEVERAL and "--output" in words:
            words = [*words[:-1], "imported" if words[0] == "import" else words[-1], "--overwrite"]
        code = main(words)
        told = capsys.readouterr()
        if words[0] == "show" and "--save" not in words:  # nothing to show it on
            assert code == 2
            assert "--save" in told.err
            continue
        assert code == 0, f"{' '.join(words)}: {told.err}"
        assert told.out.strip() or words[0] in ("import", "simulate", "recover"), " ".join(words)
        if "--urdf" in words:
            assert "backlash" in told.out
        if words[0] == "simulate":
            assert (files / words[-1 if "--overwrite" not in words else -2] / "metadata.yaml").exists()
        done += 1
    assert done


def test_a_bag_and_a_urdf_make_a_verdict_and_a_prediction_in_two_commands() -> None:
    """That they do is seen where the page is run."""
    first, second = commands("docs/own-arm.md")[:2]
    assert (first[0], second[0]) == ("diagnose", "simulate")
    assert "--urdf" in first


def test_a_page_within_another_shows_nothing_else() -> None:
    for page, other in WITHIN.items():
        there = iter(commands(other))
        assert all(words in there for words in commands(page)), page


def test_every_page_with_commands_is_run_here_or_in_a_test_of_its_own() -> None:
    shown = {str(page.relative_to(ROOT)) for page in PAGES if commands(str(page.relative_to(ROOT)))}
    assert shown <= {*RUN, *WITHIN, *ELSEWHERE}
    assert [test for tests in ELSEWHERE.values() for test in tests if not (ROOT / test).exists()] == []
