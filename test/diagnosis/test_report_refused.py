"""The page of data that are mixed up says nothing of what was not judged, and the same word as all else."""

import re

from test.diagnosis import made
from test.diagnosis.test_report import words
from trunk_ros.commands.diagnose import spoken
from trunk_ros.diagnosis.report import render
from trunk_ros.diagnosis.verdict.answer import Unexplained
from trunk_ros.diagnosis.verdict.result import Diagnosis

STATEMENT = "joint_states looks like degrees. Convert it to rad (unit: deg in a mapping) and diagnose again."


def mixed(stage: str, joints: list[str]) -> Diagnosis:
    result = made.diagnosis({}, [])
    result.unexplained.append(Unexplained(stage, joints, "always", 1.0, [], STATEMENT))
    one = {"kind": "degrees", "stage": stage, "joints": joints, "statement": STATEMENT, "certain": True}
    result.quality["run1"]["mix_ups"] = [one]
    return result


def refused() -> Diagnosis:
    result = mixed("wire", list(made.JOINTS))
    result.stages["wire"] = {"compared": False, "joints": {}, "silent": []}
    result.plots = {}
    return result


def test_what_was_not_judged_is_left_out_and_the_reason_is_said() -> None:
    page = render(refused())
    titles = re.findall("<h2[^>]*>(.*)</h2>", page)
    assert titles == ["What to do next", "Quality of the data", "To reproduce"]
    assert set(re.findall('href="#(.*?)"', page)) == {"data", "again"}
    text = words(page)
    assert "Nothing was compared: the data are mixed up, see above" in text
    assert "Put the data right and diagnose again. joint_states looks like degrees." in text
    for untrue in (
        "None is needed",
        "100 %",
        "topics or motion are missing",
        "No residual",
        "nothing judged",
    ):
        assert untrue not in text


def test_the_verdict_is_one_word_on_the_page_in_the_file_and_on_stdout() -> None:
    result = refused()
    badge = re.findall('class="badge[^>]*>(.*?)<', render(result))
    assert badge == [result.to_json()["verdict"]] == ["unexplained"]
    assert spoken(result)[0] == "verdict: unexplained"


def test_a_stage_that_is_mixed_up_is_said_to_be_that_beside_others() -> None:
    text = words(render(mixed("servo", list(made.JOINTS))))
    assert "servo (setpoint to gearbox: mixed up, see above)" in text
    assert "arm (joint to tip: topics or motion are missing)" in text
    assert "100 %" not in text
