"""Claims about which code a result rests on."""

from __future__ import annotations

from test.concealed.codes import closure, package


def test_comparisons_rest_on_the_plants_and_not_on_the_package_or_the_marks() -> None:
    names = {file.stem for file in closure("seeds", "others")}
    assert {"plant", "wire_fe", "mujoco_arm", "sensing", "boosted", "echo", "symbolic", "refit"} <= names
    assert not names & {"judge", "marks", "protocol", "solver", "evidence", "proof"}


def test_marks_rest_on_the_package_and_the_plants_but_not_on_figures_or_nodes() -> None:
    names = {file.stem for file in closure("seeds", "protocol", "solver", "marks", "removed")}
    assert {"plant", "mujoco_arm", "bag", "marks", "solver"} <= names
    assert not names & {"others", "boosted", "proof_figures", "evidence"}
    parts = {file.parent.name for file in package()}
    assert {"diagnosis", "effects", "config"} <= parts
    assert "nodes" not in parts
