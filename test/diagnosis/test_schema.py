"""What diagnose writes is as the published schema says, which refuses what the contract does not have."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from test.diagnosis.arms import PAIR, on, recorded, reshaped
from trunk_ros.data.mix_ups.pair import Kind
from trunk_ros.diagnosis import diagnose
from trunk_ros.diagnosis.verdict.answer import SCHEMA
from trunk_ros.diagnosis.verdict.schema import diagnosis_schema

jsonschema = pytest.importorskip("jsonschema")
PROOF = Path(__file__).parents[2] / "proof"


@pytest.fixture(scope="module")
def written() -> dict[str, Any]:
    made = recorded(
        {"backlash": {"half_width": on(2, 8e-4, 2)}, "cogging": {"amplitude": 2e-3, "cycles_per_rev": 8.0}},
        12.0,
        nominal=PAIR,
    )
    return diagnose(made, PAIR).to_json()


def errors(content: dict[str, Any]) -> list[str]:
    validator = jsonschema.Draft202012Validator(diagnosis_schema())
    return [f"{error.json_path}: {error.message}" for error in validator.iter_errors(content)]


def test_the_schema_is_a_schema_of_what_is_written() -> None:
    jsonschema.Draft202012Validator.check_schema(diagnosis_schema())
    assert diagnosis_schema()["$id"] == SCHEMA


def test_the_schema_knows_each_kind_of_mix_up() -> None:
    quality = diagnosis_schema()["properties"]["quality"]["additionalProperties"]["properties"]
    assert set(quality["mix_ups"]["items"]["properties"]["kind"]["enum"]) == set(get_args(Kind))


def test_a_diagnosis_is_as_the_schema_says(written: dict[str, Any]) -> None:
    assert written["findings"]
    assert errors(written) == []
    assert errors(json.loads(json.dumps(written))) == []


def test_so_is_one_of_data_that_are_mixed_up() -> None:
    made = recorded(seconds=10.0)
    degrees = np.degrees(made.series["joint_states"].position)
    assert errors(diagnose(reshaped(made, "joint_states", position=degrees)).to_json()) == []


@pytest.mark.parametrize(
    ("where", "wrong"),
    [
        (("verdict",), "maybe"),
        (("findings", 0, "confidence"), 1.2),
        (("findings", 0, "regime"), "sometimes"),
        (("findings", 0, "equivalents"), "stribeck_friction"),
        (("findings", 0, "effect"), "Back Lash"),
        (("stages", "wire", "joints", "joint_1", "rmse_before"), -1.0),
        (("experiments",), [{"separates": ["backlash"], "statement": "x", "trajectory": ""}]),
    ],
)
def test_what_the_contract_does_not_have_is_refused(
    written: dict[str, Any], where: tuple[str | int, ...], wrong: object
) -> None:
    content = json.loads(json.dumps(written))
    place = content
    for key in where[:-1]:
        place = place[key]
    place[where[-1]] = wrong
    assert errors(content)


def test_a_set_of_effects_may_be_an_equivalent(written: dict[str, Any]) -> None:
    content = json.loads(json.dumps(written))
    named = next(finding for finding in content["findings"] if finding["effect"] != "unknown")
    named["equivalents"] = ["stribeck_friction", ["backlash", "viscous_lag"]]
    assert errors(content) == []


def test_every_output_of_the_proof_that_is_here_is_as_the_schema_says() -> None:
    outputs = sorted(PROOF.rglob("diagnosis.json"))
    if not outputs:
        pytest.skip("no proof has been run here")
    wrong = {str(path): found for path in outputs if (found := errors(json.loads(path.read_text())))}
    assert wrong == {}
