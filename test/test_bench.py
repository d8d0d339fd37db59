"""The bench finds its sections by itself and writes what it measured."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from rich.console import Console

from test.bench import __main__ as bench
from test.bench import policy, reality
from test.bench.compare import changes
from test.bench.diagnosis import HIDDEN, diagnosed
from test.bench.releases import last
from test.bench.row import Row
from test.diagnosis.arms import of_the_wires, recorded
from trunk_ros import __version__
from trunk_ros.recording.write import write_recording


@pytest.mark.parametrize("name", bench.sections())
def test_every_section_says_what_it_measures(name: str) -> None:
    module = importlib.import_module(f"test.bench.{name}")
    assert module.__doc__
    assert callable(module.measure)


def test_the_speed_of_the_chain_is_a_section() -> None:
    assert "chain" in bench.sections()


def test_a_target_is_reached_from_one_side() -> None:
    assert Row("share", 0.8, "1", at_least=0.7).reached
    assert not Row("time", 120.0, "us", at_most=100).reached
    assert Row("count", 3.0, "1").reached is None


def test_the_figures_are_written_with_their_targets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def measure() -> Iterator[Row]:
        yield Row("speed", np.float64(2.0), "1/s", at_least=1.0)

    section = ModuleType("test.bench.made_up", "Made up.")
    section.measure = measure  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "test.bench.made_up", section)
    monkeypatch.setattr(bench, "sections", lambda: ["made_up"])
    assert bench.main(["--output", str(tmp_path / "bench.json")]) == 0
    written = json.loads((tmp_path / "bench.json").read_text())
    assert written["sections"]["made_up"]["rows"] == [
        {"name": "speed", "value": 2.0, "unit": "1/s", "target": "≥ 1", "reached": True}
    ]


def test_a_real_section_ends_in_a_file_with_what_it_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, few in (("ENVIRONMENTS", (1, 8)), ("STEPS", 2), ("REPEATS", 1)):
        monkeypatch.setattr(reality, name, few)
    assert bench.main(["reality", "--output", str(tmp_path / "bench.json")]) == 0
    written = json.loads((tmp_path / "bench.json").read_text())
    assert written["schema"] == "trunk_ros/bench/1"
    rows = written["sections"]["reality"]["rows"]
    assert all(row["value"] > 0.0 for row in rows)
    assert {type(row["reached"]) for row in rows} == {bool, type(None)}


def test_a_release_is_compared_with_the_newest_before_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    figures = iter((2.0, 4.0))
    section = ModuleType("test.bench.made_up", "Made up.")
    section.measure = lambda: iter([Row("time", next(figures), "s")])  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "test.bench.made_up", section)
    monkeypatch.setattr(bench, "sections", lambda: ["made_up"])
    monkeypatch.setattr(bench, "kept", lambda: tmp_path / "0.2.0.json")
    monkeypatch.setattr(bench, "last", lambda: last(tmp_path, "0.11.0"))
    assert bench.main(["--compare", "last", "--release"]) == 0
    assert "Changed since then" not in capsys.readouterr().out
    written = json.loads((tmp_path / "0.2.0.json").read_text())
    assert written["version"] == __version__
    for version in ("0.1.0", "0.12.0"):
        (tmp_path / f"{version}.json").write_text("{}")
    assert bench.main(["--compare", "last"]) == 0
    assert "+100%" in capsys.readouterr().out
    (tmp_path / "0.10.0.json").write_text("{}")
    assert last(tmp_path, "0.11.0") == tmp_path / "0.10.0.json"
    assert last(tmp_path, "0.1.0") is None


def test_an_unknown_section_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        bench.main(["nothing"])
    assert "no section nothing: choose from" in capsys.readouterr().err


def test_what_is_worse_than_in_the_last_release_is_said_first() -> None:
    def section(*values: float) -> dict:
        units = {"latency": "us", "throughput": "1/s", "share": "1", "same": "s"}
        figures = [(name, unit, "≥ 0.5" if name == "share" else None) for name, unit in units.items()]
        rows = zip(figures, values, strict=True)
        return {"made": {"rows": [{"name": n, "unit": u, "target": t, "value": v} for (n, u, t), v in rows]}}

    found = changes(section(10.0, 100.0, 0.8, 1.0), section(15.0, 150.0, 0.6, 1.05))
    assert [(each.name, each.worse) for each in found] == [
        ("made: latency", True),
        ("made: share", True),
        ("made: throughput", False),
    ]
    assert found[0].factor == pytest.approx(0.5)


def test_policy_finds_constants_and_changes_one_of_them(tmp_path: Path) -> None:
    by_name = {str(each): each for each in policy.constants()}
    assert {"context.LEAST", "sliding.SLIDES", "long.WORK"} <= set(by_name)
    slides = by_name["sliding.SLIDES"]
    assert slides.scaled(0.5) == "(0.25, 30.0)"
    assert by_name["context.LEAST"].scaled(4 / 3) == "67"
    assert policy.Constant("x.py", "MOST", 1, "2").scaled(4 / 3) == "3"
    chance, part = by_name["levels.CHANCE"], by_name["levels.PART"]
    policy.changed([(part, 0.5), (chance, 0.5)], tmp_path)
    old, new = ((root / part.path).read_text().splitlines() for root in (Path(__file__).parents[1], tmp_path))
    changes = [b for a, b in zip(old, new, strict=True) if a != b]
    assert changes == ["CHANCE = 0.005", "PART = 0.05"]
    works = (
        "from trunk_ros.levels import PART; from trunk_ros.share import config_path;"
        "config_path('trunk'); print(PART)"
    )
    said = subprocess.run(
        [sys.executable, "-c", works], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert said.stdout.strip() == "0.05"


def test_a_share_stays_below_one_and_one_is_one() -> None:
    def changed(text: str) -> list[str]:
        return [policy.Constant("x.py", "SHARE", 1, text).scaled(factor) for factor in policy.FACTORS]

    assert [float(each) for each in changed("0.9")] == pytest.approx([0.9 - 0.1 / 3, 0.9 + 0.1 / 3])
    assert [float(each) for each in changed("0.6")] == pytest.approx([0.4, 0.8])
    assert changed("(1, 4)") == ["(1, 3)", "(1, 5)"]
    assert changed("2**12") == ["2731", "5461"]


def test_policy_moves_each_constant_up_as_often_as_down() -> None:
    signs = policy.dealt(policy.constants(), 50)
    assert signs.shape == (50, len(policy.constants()))
    assert np.all(np.abs(signs) == 1)
    assert np.all(signs.sum(axis=0) == 0)
    assert np.array_equal(signs, policy.dealt(policy.constants(), 50))
    assert np.abs(np.corrcoef(signs.T) - np.eye(signs.shape[1])).max() < 0.8  # none is another one's mirror


class Pretended(policy.Bench):
    """As if one constant, when it is smaller, cost a name of every second case, and nothing else did."""

    def marks(self, name: str, changes: Sequence[policy.Change], some: Sequence[str]) -> policy.Marks:
        lower = ("levels.SURE", policy.FACTORS[0]) in [(str(each), factor) for each, factor in changes]
        lost = {case: lower and int(case.removeprefix("case_")) % 2 == 0 for case in some}
        hit, miss = {"effect": "backlash", "confidence": 0.9}, ["backlash", 3.0]
        told = {"false": [], "known": True, "count": 1, "seconds": 1.0}
        return {
            case: {**told, "hits": [hit] * (not gone), "missed": [miss] * gone} for case, gone in lost.items()
        }


@pytest.fixture
def pretended(tmp_path: Path) -> Pretended:
    for case in range(60):
        (tmp_path / f"case_{case:02d}").mkdir()
    return Pretended(tmp_path, tmp_path / "results", 1, Console(quiet=True))


def test_policy_finds_the_one_constant_that_matters(pretended: Pretended) -> None:
    every = policy.constants()
    policy.measured(pretended, every, every)
    matters = pretended.rows[0]["all_at_once"]
    others = {name: f1 for name, f1 in matters.items() if name != "levels.SURE"}
    assert matters["levels.SURE"] == pytest.approx(0.125)  # half of what it costs below, and of what it gains
    assert max(map(abs, others.values())) < matters["levels.SURE"]
    alone = {name: row["f1"] for row in pretended.rows[1:] for name in row["changed_to"] if row["f1"]}
    assert alone.keys() == {"levels.SURE"}
    assert alone["levels.SURE"] == pytest.approx(-1.0 / 3.0)  # 30 of 60 names: 60 / 90


def test_what_each_constant_does_is_known_as_well_as_is_said() -> None:
    rng, off = np.random.default_rng(5), []
    signs = policy.dealt(policy.constants(), 50)
    for _ in range(40):
        shared = signs[:, :8] @ np.full(8, 0.1) + rng.normal(0.0, 0.3, 50)  # eight matter
        found, std = policy.effects(signs, 2.0 * shared)
        off.append(np.concatenate([found[:8] - 0.1, found[8:]]) / std)
    assert 0.7 < np.std(off) < 1.1


def test_policy_tries_constants_that_are_named_alone(pretended: Pretended) -> None:
    by_name = {str(each): each for each in policy.constants()}
    policy.measured(pretended, [by_name["levels.PART"]], policy.constants())
    assert [list(row["changed_to"]) for row in pretended.rows] == [["levels.PART"]] * 2
    assert [row["f1"] for row in pretended.rows] == [0.0, 0.0]


def test_policy_does_not_go_on_with_answers_of_other_constants(tmp_path: Path) -> None:
    bench = policy.Bench(tmp_path / "cases", tmp_path / "results", 1, Console(quiet=True))
    (tmp_path / "results" / "pair_0_+1").mkdir(parents=True)
    (tmp_path / "results" / "pair_0_+1" / "changed_to.json").write_text('{"levels.PART": "0.05"}')
    with pytest.raises(RuntimeError, match="other code"):
        bench.marks("pair_0_+1", [(policy.constants()[0], 4 / 3)], [])


def test_policy_refuses_a_constant_that_there_is_not(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        bench.main(["policy", "nothing.AT_ALL"])
    assert "--list names them" in capsys.readouterr().err


def test_a_diagnosis_is_measured_with_what_it_found(tmp_path: Path) -> None:
    hidden = {"backlash": HIDDEN["backlash"]}
    write_recording(tmp_path / "run", of_the_wires(recorded(hidden, seconds=8.0)))
    took, memory, clock, found = diagnosed(tmp_path)
    assert 0.0 < took < 60.0
    assert 50.0 < memory < 2048.0
    assert clock > 0.0
    assert found
