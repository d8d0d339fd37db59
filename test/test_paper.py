"""Every number of the paper, every number that its formulas give, and what holds for the whole arm."""

import re
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from trunk_ros.arm import Arm, Wire
from trunk_ros.commands.paper import main
from trunk_ros.errors import ArgumentError
from trunk_ros.model import load_model
from trunk_ros.paper.command import FIGURES, PAGE
from trunk_ros.paper.formulas import (
    ARCMIN,
    DIFFERENTLY,
    FINE,
    FORMULAS,
    LIMIT,
    LINK,
    PRINTED_DEVIATION,
    PRINTED_ELONGATION,
    Quantity,
    deviation,
    positioning_error,
    quantities,
    swapped_deviation,
)
from trunk_ros.paper.workspace import BOTH, HYSTERESIS, STRETCH, WORST, Workspace, postures, worst_signs
from trunk_ros.paper.workspace import workspace as over_workspace

DOCUMENTED = (Path(__file__).parents[1] / "docs" / "paper.md").read_text(encoding="utf-8")
PRINTED = "printed.txt"


@pytest.fixture(scope="module")
def arm() -> Arm:
    return load_model("trunk").arm


@pytest.fixture(scope="module")
def wire(arm: Arm) -> Wire:
    assert arm.wire is not None
    return arm.wire


@pytest.fixture(scope="module")
def lines(wire: Wire) -> list[Quantity]:
    return quantities(wire)


@pytest.fixture(scope="module")
def found(arm: Arm) -> Workspace:
    return over_workspace(arm, levels=5)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The output of a run that overwrites an older one, and what it printed: each takes ten seconds."""
    out = tmp_path_factory.mktemp("run") / "paper"
    out.mkdir()
    (out / PAGE).write_text("old")
    printed = StringIO()
    with redirect_stdout(printed):
        assert main(["--output", str(out), "--overwrite"]) == 0
    (out / PRINTED).write_text(printed.getvalue(), encoding="utf-8")
    return out


@pytest.mark.parametrize("line", [0, 1, 2])
def test_every_printed_digit_of_table_2_is_reproduced(lines: list[Quantity], line: int) -> None:
    decimals = lines[line].digits
    assert lines[line].cells()[DIFFERENTLY] == [f"{float(text):.{decimals}f}" for text in lines[line].printed]


@pytest.mark.parametrize("line", [0, 1, 2])
def test_the_printed_digits_are_not_what_the_formulas_give(lines: list[Quantity], line: int) -> None:
    assert not set(lines[line].cells()[FORMULAS]) & set(lines[line].printed)


@pytest.mark.parametrize(
    ("line", "way", "values"),
    [
        (0, FORMULAS, ["86.85", "87.70", "87.70", "87.70", "87.70"]),
        (1, FORMULAS, ["5.0871", "6.5348", "7.9284", "9.3221", "10.7157"]),
        (1, FINE, ["5.0686", "6.5111", "7.8997", "9.2882", "10.6768"]),
        (2, FORMULAS, ["1.0930", "1.4041", "1.7035", "2.0029", "2.3024"]),
        (2, FINE, ["1.0890", "1.3990", "1.6973", "1.9957", "2.2940"]),
    ],
)
def test_the_formulas_give_other_values(
    lines: list[Quantity], line: int, way: str, values: list[str]
) -> None:
    assert lines[line].cells()[way] == values


def test_only_joint_1_needs_another_angle_once_the_section_is_not_rounded(lines: list[Quantity]) -> None:
    agree = [a == b for a, b in zip(lines[1].cells()[FINE], lines[1].printed, strict=True)]
    assert agree == [False, True, True, True, True]


def test_the_printed_angles_are_too_small_by_3_28(wire: Wire) -> None:
    stretch = 1e-6 * np.array(PRINTED_ELONGATION, dtype=float)
    right = stretch / wire.cylinder_radius / ARCMIN
    assert right / np.array(PRINTED_DEVIATION, dtype=float) == pytest.approx(3.28, abs=0.005)
    assert right / swapped_deviation(wire) == pytest.approx((180 / np.pi) ** 2 / 1000)


@pytest.mark.parametrize(("line", "printed", "formula"), [(3, 50, 167), (4, 20, 65)])
def test_figures_5_and_6_follow_from_the_printed_angles(
    lines: list[Quantity], line: int, printed: float, formula: float
) -> None:
    assert lines[line].printed[4] == f"~{printed}"
    assert lines[line].rows[DIFFERENTLY][4] == pytest.approx(printed, abs=1.0)
    assert lines[line].rows[FORMULAS][4] == pytest.approx(formula, abs=0.6)


def test_the_error_along_y_falls_with_the_angle_and_along_z_grows(wire: Wire) -> None:
    dy, dz = positioning_error(np.linspace(0, LIMIT, 50), deviation(wire))
    assert np.all(np.diff(dy, axis=0) < 0)
    assert np.all(np.diff(dz, axis=0) > 0)


def test_eq_7_is_eq_6_pulled_by_the_force_that_arrives(wire: Wire) -> None:
    np.testing.assert_allclose(deviation(wire), wire.dead_band * wire.efficiency, rtol=1e-12)


def test_no_posture_is_worse_for_the_dead_bands_than_the_straight_arm(arm: Arm, found: Workspace) -> None:
    levers = LINK * np.arange(5, 0, -1)
    assert found.errors[WORST][0] == pytest.approx(levers @ arm.dead_band, rel=1e-6)
    assert found.errors[WORST].max() <= found.errors[WORST][0] * (1 + 1e-6)


def test_the_hysteresis_never_exceeds_the_worst_signs(found: Workspace) -> None:
    assert np.all(found.errors[HYSTERESIS] <= found.errors[WORST] + 1e-12)


def test_joints_that_all_come_from_one_side_have_the_worst_signs(found: Workspace) -> None:
    np.testing.assert_allclose(found.errors[HYSTERESIS][:2], found.errors[WORST][:2], rtol=1e-3)


def test_a_straight_arm_does_not_sag(found: Workspace) -> None:
    assert found.errors[STRETCH][0] == pytest.approx(0.0, abs=1e-12)


def test_the_stretch_is_the_compliance_times_the_load(arm: Arm, found: Workspace) -> None:
    theta = postures(arm, 5)[2:3]
    once = arm.tip(theta + arm.compliance * arm.load(theta)) - arm.tip(theta)
    assert found.errors[STRETCH][1] == pytest.approx(np.hypot(*once[0, 1:3]), rel=0.02)


def test_the_weight_matters_more_than_the_friction(found: Workspace) -> None:
    assert found.errors[STRETCH].max() > 5 * found.errors[WORST].max()
    assert found.errors[BOTH].max() > 5 * found.errors[WORST].max()


@pytest.mark.parametrize("cause", [WORST, HYSTERESIS, STRETCH, BOTH])
def test_the_errors_at_the_tip_are_as_documented(cause: str, made: Path) -> None:
    text = (made / PAGE).read_text(encoding="utf-8")
    row = text[text.rindex(f"<th>{cause}</th>") :].partition("</tr>")[0]
    assert f"| {cause} | {' | '.join(re.findall(r'[0-9]+[.][0-9]{3}', row))} |" in DOCUMENTED


@pytest.mark.parametrize("line", [0, 1, 2])
def test_table_2_is_as_documented(lines: list[Quantity], line: int) -> None:
    for cells in lines[line].cells().values():
        assert f" | {' | '.join(cells)} |" in DOCUMENTED


def test_worst_signs_are_symmetric(arm: Arm) -> None:
    theta = np.random.default_rng(1).uniform(arm.lower, arm.upper, (20, 5))
    np.testing.assert_allclose(worst_signs(arm, theta), worst_signs(arm, -theta), rtol=1e-12)


def test_the_page_is_one_file_beside_its_figures(made: Path) -> None:
    assert sorted(each.name for each in made.iterdir()) == sorted((PAGE, *FIGURES, PRINTED))
    text = (made / PAGE).read_text(encoding="utf-8")
    assert "10.6768" in text
    assert "3.28" in text
    assert text.count("data:image/png;base64,") == 2
    assert not [word for word in ("http://", "https://", 'src="paper') if word in text]
    printed = (made / PRINTED).read_text(encoding="utf-8")
    assert "10.6768" in printed
    assert "Δl[µm]/R_c[mm]" in printed


def test_an_existing_output_is_refused_and_left_alone(tmp_path: Path) -> None:
    (tmp_path / PAGE).write_text("mine")
    with pytest.raises(ArgumentError, match="exists"):
        main(["--output", str(tmp_path)])
    assert (tmp_path / PAGE).read_text() == "mine"


def test_overwrite_spares_a_folder_that_holds_other_things(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(ArgumentError, match=r"thesis\.tex"):
        main(["--output", str(tmp_path), "--overwrite"])


@pytest.mark.parametrize("arguments", [["--outptu", "x"], ["--output"], ["--output", "/dev/null/paper"]])
def test_a_bad_argument_is_one_line_and_exit_2(arguments: list[str]) -> None:
    ran = subprocess.run(
        [sys.executable, "-m", "trunk_ros", "paper", *arguments],
        capture_output=True,
        text=True,
        timeout=60,
        cwd=Path(__file__).parents[1],
    )
    assert ran.returncode == 2
    assert len(ran.stderr.splitlines()) == 1
    assert not ran.stdout
