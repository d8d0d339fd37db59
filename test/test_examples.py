"""The worked examples run as they stand, and print what their page says."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
SCRIPTS = sorted((ROOT / "examples").glob("*.py"))
NEEDS = {"learning_environment": "gymnasium"}
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_an_example_prints_what_its_page_says(script: Path, tmp_path: Path) -> None:
    if (need := NEEDS.get(script.stem)) and importlib.util.find_spec(need) is None:
        pytest.skip(f"{need} is not installed here")
    shown = PAGE.partition(f"python examples/{script.name}\n")[2].partition("```")[0]
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert words(done.stdout) == words(shown)
    for found, told in zip(NUMBER.findall(done.stdout), NUMBER.findall(shown), strict=True):
        assert last_digit(found) >= last_digit(told), f"{found} is shown as {told}"
        assert float(found) == pytest.approx(float(told), rel=0.1, abs=1.1 * last_digit(told))


def words(text: str) -> list[str]:
    """All but the numbers; columns may be wider or narrower."""
    return NUMBER.sub("#", text).split()


def last_digit(number: str) -> float:
    """What one more in its last digit is."""
    digits, _, power = number.partition("e")
    return float(f"1e{int(power or 0) - len(digits.partition('.')[2])}")


def test_every_example_is_on_the_page() -> None:
    shown = re.findall(r"python examples/(\w+)\.py", PAGE)
    assert sorted(shown) == [script.stem for script in SCRIPTS]
