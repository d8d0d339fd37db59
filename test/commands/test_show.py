"""``show``: what the files for Rerun and Foxglove hold of a recording and a model."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from test.diagnosis.arms import on, recorded
from trunk_ros.__main__ import main
from trunk_ros.arm.urdf import urdf
from trunk_ros.errors import ModelError
from trunk_ros.model import Model, load_model, save_model
from trunk_ros.recording.read import read_recording
from trunk_ros.recording.write import write_recording
from trunk_ros.show.ghosts import ghost
from trunk_ros.show.layout import NEVER
from trunk_ros.show.scene import scene

WIDTH = 5e-3


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bag of an arm with backlash on joint_2, and a verdict on it."""
    here = tmp_path_factory.mktemp("show")
    effects = {"backlash": {"half_width": on(2, WIDTH)}}
    write_recording(here / "run", recorded(effects, 10.0))
    (here / "verdict").mkdir()
    save_model(Model(load_model("trunk").arm, effects), here / "verdict" / "model.yaml")
    found = {
        "effect": "backlash", "stage": "wire", "joints": ["joint_2"], "regime": "reversal",
        "confidence": 0.9, "statement": "joint_2: an added dead band.",
    }  # fmt: skip
    told = {"verdict": "explained", "findings": [found], "unexplained": []}
    (here / "verdict" / "diagnosis.json").write_text(json.dumps(told))
    return here


def test_the_fitted_arm_follows_where_the_nominal_does_not() -> None:
    effects = {"backlash": {"half_width": on(2, WIDTH)}}
    shown = scene(recorded(effects, 10.0), Model(load_model("trunk").arm, effects))
    nominal, fitted = (
        np.sqrt(np.mean((shown.measured - y)[300:] ** 2, axis=0)) for y in (shown.nominal, shown.fitted)
    )
    assert nominal[1] == pytest.approx(WIDTH, rel=0.1)
    assert fitted.max() < 1.5e-4
    assert "backlash" in shown.statement


def test_a_ghost_has_one_colour_and_collides_with_nothing() -> None:
    text = urdf(load_model("trunk").arm)
    robot = ElementTree.fromstring(ghost(text, "0 1 0 0.3"))
    assert not list(robot.iter("collision"))
    colours = [m.find("color") for m in robot.findall("link/visual/material")]
    assert [c is not None and c.get("rgba") for c in colours] == ["0 1 0 0.3"] * 5
    with pytest.raises(ModelError, match="not URDF"):
        ghost("no xml", None)


def test_a_file_holds_three_arms_residuals_and_the_findings(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("rerun")
    target = folder / "run.rrd"
    arguments = ["show", str(folder / "run"), "-m", str(folder / "verdict" / "model.yaml")]
    assert main([*arguments, "--save", str(target)]) == 0
    assert "1000 samples of joint_1" in capsys.readouterr().out
    held = target.read_bytes()
    for kind in ("measured", "nominal", "fitted"):
        assert f"/{kind}/joints/joint_5".encode() in held
    assert b"/residuals/joint_2/fitted" in held
    assert b"/regimes/joint_2/backlash_0" in held
    assert main([*arguments, "--save", str(target)]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert not list(folder.glob(".*.part"))


@pytest.fixture(scope="module")
def saved(folder: Path) -> tuple[dict[str, list[tuple[float, Any]]], dict[str, Any]]:
    """Messages by topic with their time [s], and the layout, that ``show --save run.mcap`` writes."""
    target = folder / "run.mcap"
    arguments = ["show", str(folder / "run"), "-m", str(folder / "verdict" / "model.yaml")]
    assert main([*arguments, "--save", str(target)]) == 0
    assert main([*arguments, "--save", str(target)]) == 2
    held: dict[str, list[tuple[float, Any]]] = {}
    with AnyReader([target], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        for connection, ns, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            held.setdefault(connection.topic, []).append((ns * 1e-9, message))
    assert not list(folder.glob(".run*"))
    return held, json.loads((folder / "run.layout.json").read_text())


def test_an_mcap_holds_what_rerun_shows(folder: Path, saved: tuple[dict, dict]) -> None:
    held, _ = saved
    shown = scene(read_recording(folder / "run"), load_model(folder / "verdict" / "model.yaml"))
    for kind in ("measured", "nominal", "fitted"):
        angles = np.array([message.position for _, message in held[f"/{kind}/joint_states"]])
        np.testing.assert_array_equal(angles, getattr(shown, kind))
        assert "<robot" in held[f"/{kind}/robot_description"][0][1].data
    left = np.array([message.position[1] for _, message in held["/residuals/nominal"]])
    np.testing.assert_allclose(left, 1e3 * (shown.measured - shown.nominal)[:, 1])
    states = [message.data for _, message in held["/regimes/joint_2/backlash_0"]]
    assert "reversal" in states
    assert states[-1] == NEVER


def test_its_frames_put_the_tip_where_the_model_has_it(saved: tuple[dict, dict]) -> None:
    held, _ = saved
    (time, message), arm = held["/tf"][-1], load_model("trunk").arm
    place, turn = np.zeros(3), Rotation.identity()
    for one in message.transforms:
        move, by = one.transform.translation, one.transform.rotation
        place = place + turn.apply([move.x, move.y, move.z])
        turn = turn * Rotation.from_quat([by.x, by.y, by.z, by.w])
    kind = one.child_frame_id.partition("/")[0]
    angles = next(m.position for t, m in held[f"/{kind}/joint_states"] if t == time)
    np.testing.assert_allclose(place, arm.tip(angles[None])[0][:3], atol=1e-9)


def test_each_panel_of_its_layout_is_placed_and_each_path_leads_to_a_topic(saved: tuple[dict, dict]) -> None:
    held, layout = saved
    panels = layout["configById"]

    def leaves(node: Any) -> list[str]:
        return [node] if isinstance(node, str) else leaves(node["first"]) + leaves(node["second"])

    placed = leaves(layout["layout"])
    tabs = [leaf for tab in panels["Tab!joints"]["tabs"] for leaf in leaves(tab["layout"])]
    assert sorted(placed + tabs) == sorted(panels)
    paths = [path["value"] for panel in panels.values() for path in panel.get("paths", [])]
    assert {path.partition(".")[0] for path in paths} <= set(held)
    layers = [one for one in panels["3D!arm"]["layers"].values() if one["layerId"] == "foxglove.Urdf"]
    roots = {one.child_frame_id for one in held["/tf"][0][1].transforms}
    assert {f"{one['framePrefix']}base_link" for one in layers} == roots
    assert {one["topic"] for one in layers} <= set(held)


def test_another_suffix_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", str(folder / "run"), "-m", "trunk", "--save", "run.txt"]) == 2
    assert "FILE.rrd for Rerun or FILE.mcap for Foxglove" in capsys.readouterr().err


def test_without_a_screen_it_says_how_to_save(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("rerun")
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert main(["show", str(folder / "run"), "-m", "trunk"]) == 2
    assert "--save FILE.rrd" in capsys.readouterr().err


def test_a_urdf_of_another_arm_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("rerun")
    other = folder / "other.urdf"
    other.write_text(urdf(load_model("trunk").arm).replace('name="joint_4"', 'name="elbow"'))
    target = folder / "other.rrd"
    arguments = ["show", str(folder / "run"), "-m", "trunk", "--urdf", str(other), "--save", str(target)]
    assert main(arguments) == 2
    assert "no joint 'joint_4'" in capsys.readouterr().err
    assert not target.exists()
