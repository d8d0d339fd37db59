"""The example of docs/adding-an-effect.md, in a folder of the user's own: one new file and nothing else."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from trunk_ros.effects import registry
from trunk_ros.errors import ModelError

ROOT = Path(__file__).parent.parent.parent
PAGE = ROOT / "docs" / "adding-an-effect.md"
START = """
import numpy as np
from trunk_ros.chain import Chain
from trunk_ros.effects import registry
from trunk_ros.model import Model, declared_parameters, load_model, save_model

model = Model(load_model("trunk").arm, {"winding_growth": {"growth": np.linspace(0.001, 0.005, 5)}})
chain, stamp = Chain(model, "wire"), np.arange(500) * 0.01
wanted = 0.2 * np.sin(stamp[:, None] * [1.0, 1.1, 1.2, 1.3, 1.4])
"""


def test_the_example_is_short() -> None:
    shown = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len([line for line in shown[0].splitlines() if line]) <= 16


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the example as the page prints it."""
    code = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert code
    (tmp_path / "winding_growth.py").write_text(code[1], encoding="utf-8")
    return tmp_path


def python(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python with the folder's effects."""
    environment = os.environ | {"TRUNK_ROS_EFFECTS": str(folder)}
    return subprocess.run(
        [sys.executable, *arguments], cwd=ROOT, env=environment, capture_output=True, text=True
    )


def works(folder: Path, code: str) -> None:
    """Run code after the common start; whatever it asserts holds."""
    done = python(folder, "-c", START + code)
    assert done.returncode == 0, done.stderr


def test_the_list_of_effects_says_in_words_what_it_is(folder: Path) -> None:
    listed = python(folder, "-m", "trunk_ros", "effects").stdout
    assert re.search(r"winding_growth +.*Wire wound up in layers", listed)


def test_it_is_simulated_compensated_declared_by_the_nodes_and_kept_in_a_model_file(folder: Path) -> None:
    file = folder / "model.yaml"
    works(
        folder,
        "from pathlib import Path\n"
        "plain = Chain(Model(model.arm), 'wire').run(wanted, stamp)[0]\n"
        "bent = chain.run(wanted, stamp)[0] - plain\n"
        "growth = model.effects['winding_growth']['growth']\n"
        "assert np.abs(bent - growth * wanted**2).max() < 1e-5\n"
        "assert np.abs(chain.run(chain.invert(wanted, stamp)[0], stamp)[0] - wanted).max() < 1e-6\n"
        "d, = [d for d in declared_parameters() if d.name == 'effects.winding_growth.growth']\n"
        "assert (d.default, d.unit, d.bounds) == ([0.0], '1/rad', (-0.1, 0.1))\n"
        f"save_model(model, Path({str(file)!r}))\n"
        f"assert load_model({str(file)!r}).parameters() == model.parameters()",
    )


def test_it_is_held_to_what_every_effect_promises(folder: Path) -> None:
    tests = ["test/effects/test_conformance.py", "test/effects/test_recovery.py"]
    done = python(folder, "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests, "-k", "winding_growth")
    assert done.returncode == 0, done.stdout
    assert re.search(r"\b1[0-9] passed", done.stdout)


def test_the_commands_of_the_page_run_as_it_prints_them(folder: Path, tmp_path: Path) -> None:
    page = PAGE.read_text(encoding="utf-8")
    shown = re.search(r"```yaml\n# (\S+)\n(.*?)```", page, re.DOTALL)
    assert shown
    (tmp_path / shown[1]).write_text(shown[2])
    commands = re.findall(r"^trunk_ros (\w+) (\S+)$", page, re.MULTILINE)
    assert commands == [("effects", "winding_growth"), ("check", "grown.yaml")]
    for name, what in commands:
        words = [name, str(tmp_path / what) if what == shown[1] else what]
        done = python(folder, "-m", "trunk_ros", *words)
        assert (done.returncode, done.stderr) == (0, "")
        assert "growth" in done.stdout
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    done = python(elsewhere, "-m", "trunk_ros", "check", str(tmp_path / shown[1]))
    assert "unknown effect 'winding_growth' (one of your own is found where" in done.stderr
    assert "TRUNK_ROS_EFFECTS" in done.stderr


def test_without_the_folder_it_is_unknown(folder: Path) -> None:
    empty = folder / "empty"
    empty.mkdir()
    done = python(empty, "-c", START + "chain")
    assert "unknown effect 'winding_growth'" in done.stderr


def refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Why the effects of a folder are not loaded."""
    monkeypatch.setenv("TRUNK_ROS_EFFECTS", str(folder))
    with pytest.raises(ModelError) as why:
        registry.__wrapped__()  # as a process that begins looks
    sys.modules.pop("trunk_ros_effect_mine", None)
    return str(why.value)


LACKS = """
from trunk_ros.effects import Effect
class Mine(Effect):
    id = "mine"
    stage, regime = "wire", "posture"
    parameters = ()
"""
ODD = """
from trunk_ros.effects import Effect
class Mine(Effect):
    id, signature, source = "mine", "", ""
    stage, place, regime = "motor", 1, "posture"
    parameters = ()
"""
IDLE = """
from trunk_ros.effects import Effect
class Mine(Effect):
    id, signature, source = "mine", "", ""
    stage, place, regime = "wire", 1, "posture"
    parameters = ()
"""
SAME = """
from trunk_ros.effects import Effect
class Backlash(Effect):
    id = "backlash"
    stage, place = "wire", 1
"""


@pytest.mark.parametrize(
    ("file", "message"),
    [
        ("def broken(:", "cannot load an effect from .*SyntaxError"),
        ("import nothing_of_the_kind", "cannot load an effect from .*ModuleNotFoundError"),
        (LACKS, "mine.py: the effect Mine lacks place, signature, source: docs/adding-an-effect.md"),
        (ODD, "mine.py: the effect Mine has the stage 'motor': choose from servo, wire, arm"),
        (IDLE, "mine.py: the effect Mine does nothing: it has neither of run, adjust"),
        (SAME, "defines the effect 'backlash', which exists"),
    ],
)
def test_a_file_that_is_no_effect_is_refused_in_one_line(
    file: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mine.py").write_text(file)
    assert re.fullmatch(f".*{message}.*", refused(tmp_path, monkeypatch))


def test_an_error_in_it_is_said_in_one_line_with_its_place(folder: Path) -> None:
    file = folder / "winding_growth.py"
    code = file.read_text(encoding="utf-8")
    head, _, body = code.partition("    def run(")
    line = f"    def run({body}".splitlines()[0]
    file.write_text(f"{head}{line}\n        return x / missing, state\n", encoding="utf-8")
    where = f"{file}:{head.count(chr(10)) + 2}: NameError: name 'missing' is not defined"
    code = (
        "from trunk_ros import __main__ as command\n"
        "from trunk_ros.diagnosis.resources.cores import _outcome\n"
        "from trunk_ros.diagnosis.resources.work import Work\n"
        "def fails(arguments): chain.run(wanted, stamp)\n"
        "command.importlib.import_module = lambda name: type('Module', (), {'main': staticmethod(fails)})\n"
        "assert isinstance(_outcome(0, Work(1.0), fails, [])[1], command.TrunkError)\n"
        "sys.exit(command.main(['check']))"
    )
    done = python(folder, "-c", f"import sys\n{START}{code}")
    assert (done.returncode, done.stderr) == (2, f"trunk_ros: {where} (an effect of your own)\n")


def test_a_folder_that_is_not_there_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gone = tmp_path / "gone"
    assert refused(gone, monkeypatch) == f"TRUNK_ROS_EFFECTS names {gone}, which is not a folder"


@pytest.mark.timeout(240)
def test_a_diagnosis_names_it_and_its_model_predicts_another_run(folder: Path) -> None:
    works(
        folder,
        "from test.diagnosis.arms import diagnose, of_the_wires, on, recorded\n"
        "from trunk_ros.diagnosis.report import render\n"
        "from trunk_ros.simulate import simulate\n"
        "hidden = {'winding_growth': {'growth': on(3, 0.03)}}\n"
        "result = diagnose([of_the_wires(recorded(hidden, seconds=15.0))])\n"
        "found, = result.findings\n"
        "assert (found.effect, found.joints) == ('winding_growth', ['joint_3']), result.findings\n"
        "assert abs(found.parameters['joint_3']['growth']['value'] - 0.03) < 0.003\n"
        "page = render(result)\n"
        "assert '<h3>winding growth: joint_3</h3>' in page\n"
        "assert 'bends like a parabola' in page\n"
        "other = recorded(hidden, seconds=15.0, seed=5, noise=0.0)\n"
        "shown = simulate(other, result.model).series['joint_states'].position\n"
        "assert np.abs(shown - other.series['joint_states'].position)[300:].max() < 3e-4",
    )


def test_an_effect_of_another_package_is_found_by_its_entry_point(tmp_path: Path) -> None:
    code = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert code
    (tmp_path / "elsewhere.py").write_text(code[1])
    info = tmp_path / "elsewhere-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: elsewhere\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[trunk_ros.effects]\nexample = elsewhere\n")
    look = "[n for n, kind in registry().items() if kind.__module__ == 'elsewhere']"
    done = subprocess.run(
        [sys.executable, "-c", f"from trunk_ros.effects import registry; print({look})"],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": f"{ROOT}:{tmp_path}"},
    )
    assert done.stdout.strip() == "['winding_growth']", done.stderr
