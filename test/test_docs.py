"""What the pages show can be used as it stands, and what they name exists."""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from test.diagnosis.arms import on, recorded
from trunk_ros.__main__ import main
from trunk_ros.arm.parameters import declared_arm
from trunk_ros.effects import effect, registry
from trunk_ros.model import load_model
from trunk_ros.recording.importing.mapping import load_mapping
from trunk_ros.recording.topics import TOPICS
from trunk_ros.trajectory import Trajectory, save_trajectory

DOCS = Path(__file__).parents[1] / "docs"
OWN_ARM = (DOCS / "own-arm.md").read_text(encoding="utf-8")
PHYSICS = (DOCS / "physics.md").read_text(encoding="utf-8")


@pytest.fixture
def files(tmp_path: Path) -> Path:
    """The YAML blocks of own-arm.md under the names that they carry."""
    for name, text in re.findall(r"```yaml\n# (\S+)\n(.*?)```", OWN_ARM, re.DOTALL):
        (tmp_path / name).write_text(text)
    return tmp_path


def test_the_arm_of_own_arm_is_a_model(files: Path) -> None:
    assert load_model(files / "my-arm.yaml").arm.joints == ("shoulder", "elbow", "wrist")


def test_the_mapping_of_own_arm_is_a_mapping(files: Path) -> None:
    assert load_mapping(files / "my-map.yaml").joints == ("shoulder", "elbow")


def test_nodes_take_the_numbers_of_own_arm(files: Path) -> None:
    tree = yaml.safe_load((files / "my-arm.yaml").read_text())["/**"]["ros__parameters"]
    values = [each for group in tree.values() for listed in group.values() for each in listed]
    assert {type(each) for each in values} == {str, float}


def test_every_parameter_of_an_arm_is_on_the_page() -> None:
    missing = [d.name for d in declared_arm() if d.name.partition(".")[2] not in OWN_ARM]
    assert missing == ["recording.duration"]


def test_the_effects_that_a_page_names_exist() -> None:
    seen = OWN_ARM.partition("| to see |")[2].partition("\n\n")[0]
    named = [name for row in seen.splitlines() for name in re.findall(r"`(\w+)`", row.split(" | ")[0])]
    assert len(named) > 15
    assert [name for name in named if name not in registry()] == []


def test_the_order_on_the_page_is_the_order_of_the_wire() -> None:
    table = PHYSICS.partition("| place | effects |")[2].partition("\n\n")[0]
    places = [effect(name).place for name in re.findall(r"`(\w+_\w+|backlash)`", table)]
    assert len(places) > 15
    assert places == sorted(places)


def test_every_topic_that_is_read_is_on_the_page() -> None:
    assert [topic for topic in TOPICS.values() if f"`{topic}`" not in OWN_ARM] == ["trunk/wire_states"]


@pytest.mark.parametrize("page", ["paper.md", "physics.md", "own-arm.md"])
def test_every_link_to_a_file_leads_somewhere(page: str) -> None:
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", (DOCS / page).read_text(encoding="utf-8"))
    assert [link for link in links if not (DOCS / link).exists()] == []


@pytest.mark.parametrize("page", ["commands.md", "python.md", "diagnosis-json.md"])
def test_links_of_the_users_pages_lead_somewhere(page: str) -> None:
    links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", (DOCS / page).read_text(encoding="utf-8"))
    assert [link for link in links if not (DOCS / link).exists()] == []


def test_the_page_of_commands_prints_what_the_command_prints(capsys: pytest.CaptureFixture[str]) -> None:
    shown = (DOCS / "commands.md").read_text(encoding="utf-8").partition("$ trunk_ros effects backlash\n")[2]
    assert main(["effects", "backlash"]) == 0
    assert capsys.readouterr().out == shown.partition("```")[0]


def test_five_lines_lead_from_a_table_to_a_verdict(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = recorded({"backlash": {"half_width": on(2, 5e-3)}}, 20.0)
    motor = np.degrees(made.series["gearbox_states"].position[:, 1] * 0.625)
    joint = np.degrees(made.series["joint_states"].position[:, 1])
    table = np.column_stack([made.series["joint_states"].stamp, motor, joint])
    np.savetxt(tmp_path / "run1.csv", table, delimiter=",", header="t,motor_deg,joint_deg", comments="")
    code = re.search(r"```python\n(.*?)```", (DOCS / "python.md").read_text(encoding="utf-8"), re.DOTALL)
    assert code
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(code[1], names)
    assert [finding.effect for finding in names["result"].findings] == ["backlash"]


def test_own_arm_samples_an_experiment_for_a_controller(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "verdict").mkdir()
    motion = Trajectory(("elbow",), np.array([0.0, 1.0]), np.array([[0.0], [0.5]]))
    save_trajectory(tmp_path / "verdict" / "experiment_wire.yaml", motion)
    code = OWN_ARM.partition("*No ROS*")[2].partition("```python\n")[2].partition("```")[0]
    monkeypatch.chdir(tmp_path)
    exec(code, {})
    table = np.genfromtxt(tmp_path / "wanted.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["elbow"], 0.5 * table["t_s"], atol=1e-9)
