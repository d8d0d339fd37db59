"""What the pages show can be used as it stands, and what they name exists."""

import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from test.diagnosis.arms import on, recorded
from trunk_ros.__main__ import COMMANDS, main
from trunk_ros.arm.parameters import declared_arm
from trunk_ros.effects import effect, registry
from trunk_ros.model import load_model
from trunk_ros.nodes.run.plan import plan_of
from trunk_ros.recording.importing.mapping import load_mapping
from trunk_ros.recording.topics import TOPICS
from trunk_ros.trajectory import Trajectory, save_trajectory

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted(DOCS.glob("*.md"))]
PACKAGE = ROOT / "trunk_ros"
DIAGNOSIS, RECORDING = PACKAGE / "diagnosis", PACKAGE / "recording"
BASES = [ROOT, PACKAGE, DIAGNOSIS, RECORDING, PACKAGE / "nodes", PACKAGE / "fleet", PACKAGE / "effects"]
MADE = {
    "verdict/report.html",
    "verdict/model.yaml",
    "test/bench/releases/",
    "test/bench/releases/VERSION.json",
}
"""What commands and releases make."""
ROOMS = {"trunk_ros", "test", "docs", "config", "launch", "tools", "requirements"} | {
    room.name for room in (*DIAGNOSIS.iterdir(), *RECORDING.iterdir(), PACKAGE / "data") if room.is_dir()
}
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


def test_effects_that_are_known_are_told_as_the_page_tells_them(files: Path) -> None:
    model = load_model(files / "my-known-arm.yaml")
    assert set(model.effects) == {"load_elasticity", "joint_coupling", "viscous_lag"}
    assert model.effects["load_elasticity"]["upstream"] == 1.0
    assert model.effects["load_elasticity"]["payload_from"] == 30.0
    assert model.effects["joint_coupling"]["source"] == ["", "shoulder", ""]
    assert model.effects["viscous_lag"]["form"] == "proportional"


def test_the_mapping_of_own_arm_is_a_mapping(files: Path) -> None:
    assert load_mapping(files / "my-map.yaml").joints == ("shoulder", "elbow")


def test_nodes_take_the_numbers_of_own_arm(files: Path) -> None:
    tree = yaml.safe_load((files / "my-arm.yaml").read_text())["/**"]["ros__parameters"]
    values = [each for group in tree.values() for one in group.values() for each in np.ravel(one).tolist()]
    assert {type(each) for each in values} == {str, float}


def test_every_parameter_of_an_arm_is_on_the_page() -> None:
    missing = [d.name for d in declared_arm() if d.name.partition(".")[2] not in OWN_ARM]
    assert missing == []


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


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    links = re.findall(r"\]\((?!https?:)([^)#\s]*)(?:#([^)\s]*))?\)", without_code(page))
    ends = [((page.parent / link).resolve() if link else page, anchor) for link, anchor in links]
    assert [end for end, _ in ends if not end.exists()] == []
    assert [(end.name, anchor) for end, anchor in ends if anchor and anchor not in anchors(end)] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_path_in_backticks_exists(page: Path) -> None:
    inside = re.findall(r"`([\w.-]*(?:/[\w.-]*)+|\w+\.py)`", without_code(page))
    named = {name for name in inside if name.partition("/")[0] in ROOMS or name.endswith(".py")} - MADE
    tried = {name: [room / f"{name}{end}" for room in BASES for end in ("", ".py")] for name in named}
    there = {name for name, places in tried.items() if any(place.exists() for place in places)}
    assert named - there == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_command_on_a_page_is_understood(page: Path) -> None:
    shown = re.findall(r"^ *(?:\$ )?trunk_ros ([a-z_]\w*)([^#\n]*)", fenced(page), re.MULTILINE)
    for name, rest in shown:
        assert name in COMMANDS, name
        if not COMMANDS[name][0].startswith("trunk_ros.commands."):
            continue
        known = importlib.import_module(COMMANDS[name][0]).parser()._option_string_actions
        options = [word for word in shlex.split(rest) if re.match(r"--?[a-z]", word)]
        assert [option for option in options if option not in known] == [], name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_make_target_on_a_page_exists(page: Path) -> None:
    targets = re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    shown = re.findall(r"(?:^|`)make ([a-z]+)", page.read_text(encoding="utf-8"), re.MULTILINE)
    assert set(shown) <= set(targets)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_module_that_a_page_runs_exists(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    modules = set(re.findall(r"python -m ((?:trunk_ros|test)(?:\.\w+)*)", text))
    assert [module for module in modules if importlib.util.find_spec(module) is None] == []


def test_index_and_site_have_every_page() -> None:
    pages = {page.name for page in DOCS.glob("*.md")} - {"index.md"}
    linked = set(re.findall(r"\]\(([\w-]+\.md)\)", (DOCS / "index.md").read_text(encoding="utf-8")))
    listed = re.findall(r": ([\w-]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE)
    assert linked == pages
    assert sorted(listed) == sorted(pages | {"index.md"})


def test_the_readme_has_the_five_lines_of_the_page() -> None:
    shown = re.search(r"```python\n.*?```", (DOCS / "python.md").read_text(encoding="utf-8"), re.DOTALL)
    assert shown
    assert shown[0] in (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    pytest.importorskip("mkdocstrings")
    pytest.importorskip("material")
    words = ["build", "--strict", "--quiet", "--site-dir", str(tmp_path / "site")]
    done = subprocess.run([sys.executable, "-m", "mkdocs", *words], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    api = (tmp_path / "site" / "api" / "index.html").read_text(encoding="utf-8")
    assert "trunk_ros.diagnosis.diagnose.diagnose" in api
    assert "environments, joints" in api


def without_code(page: Path) -> str:
    """The text of a page without its fenced blocks."""
    return re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def fenced(page: Path) -> str:
    """The fenced blocks of a page."""
    text = page.read_text(encoding="utf-8")
    return "\n".join(re.findall(r"^```.*?^```", text, re.DOTALL | re.MULTILINE))


def anchors(page: Path) -> set[str]:
    """What a link into a page can end at, as GitHub and MkDocs make it of headings."""
    text = without_code(page)
    heads = [head.lower() for head in re.findall(r"^#+ (.*)$", text, re.MULTILINE)]
    made = {re.sub(r"[^\w\s-]", "", head).strip().replace(" ", "-") for head in heads}
    return made | set(re.findall(r'<a id="([^"]+)"', text))


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


def test_bringup_takes_the_motion_of_own_arms_arm_as_own_arm_plays_it(
    files: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (files / "verdict").mkdir()
    motion = Trajectory(("wrist",), np.array([0.0, 1.0]), np.array([[0.0], [0.2]]))
    save_trajectory(files / "verdict" / "experiment_wire.yaml", motion)
    monkeypatch.chdir(files)
    (shown,) = re.findall(r"^trunk_ros bringup (.*)$", OWN_ARM, re.MULTILINE)
    assert plan_of(shlex.split(shown)).arm.joints == ("shoulder", "elbow", "wrist")
