"""Commands on the page can be pasted: they have the arguments of the diagnosis, and the files are there."""

import html
import re
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from test.diagnosis import made
from test.diagnosis.arms import on, recorded
from trunk_ros.__main__ import main
from trunk_ros.commands.diagnose import parser
from trunk_ros.diagnosis.report import render
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.nodes.run.arguments import parser as bringup
from trunk_ros.recording.write import write_recording

MOTION = {"separates": ["backlash", "tension_error"], "statement": "x", "trajectory": "experiment_wire.yaml"}


def commands(page: str) -> list[list[str]]:
    """The words of every command that is printed to be pasted."""
    found = re.findall(r"<pre><code>(.*?)</code></pre>", page, re.S)
    text = html.unescape("\n".join(found)).replace("\\\n", " ")
    return [shlex.split(line) for line in text.splitlines()]


def told(**provenance: Any) -> Diagnosis:
    result = replace(made.backlash(), experiments=[MOTION])
    result.provenance |= provenance
    return result


def of(page: str, name: str) -> list[str]:
    return next(words[2:] for words in commands(page) if words[1] == name)


def test_the_commands_after_a_motion_have_the_arguments_of_the_first_diagnosis() -> None:
    given = {"model": "my arm.yaml", "until": "5", "namespace": "/left", "output": "out"}
    page = render(told(model="my arm.yaml", bags=["a b"], arguments=given))
    again = parser().parse_args(of(page, "diagnose"))
    assert (again.bag, again.model, again.until) == (["a b", "decisive"], "my arm.yaml", "5")
    assert (again.namespace, again.output) == ("/left", "settled")
    played = bringup().parse_args([*of(page, "bringup")[:-1], "9"])
    assert (played.model, played.trajectory) == ("my arm.yaml", "out/experiment_wire.yaml")
    assert of(page, "evaluate") == ["another_run", "-m", "out/model.yaml", "--namespace", "/left"]
    assert of(page, "compensator")[-1] == "out/model.yaml"
    assert "--until 5 holds for the new recording as well" in page


@pytest.mark.parametrize("given", [{"urdf": "arm.urdf"}, {}])
def test_after_a_urdf_the_arm_of_bringup_is_the_model_that_was_written(given: dict[str, str]) -> None:
    page = render(told(model=given.get("urdf", "robot_description"), arguments=given))
    again = parser().parse_args(of(page, "diagnose"))
    assert (again.model, again.urdf) == (None, given.get("urdf"))
    assert bringup().parse_args([*of(page, "bringup")[:-1], "9"]).model == "model.yaml"


def test_the_nominal_arm_needs_no_model() -> None:
    page = render(told(model="trunk", arguments={"output": "v"}))
    assert "-m" not in of(page, "bringup") + of(page, "diagnose")
    assert "holds for the new recording" not in page


def test_diagnose_hands_on_what_it_was_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_recording(tmp_path / "run1", recorded({"backlash": {"half_width": on(2, 8e-4)}}, 20.0))
    assert main(["diagnose", "run1", "-m", "trunk", "--until", "90%", "-o", "v"]) == 0
    page = (tmp_path / "v" / "report.html").read_text()
    assert (tmp_path / of(page, "evaluate")[-1]).is_file()
    assert all("90%" in words for words in commands(page) if words[1] == "diagnose")
    assert page.count("run1, 0 to 17.99 s of 19.99 s") == 2
