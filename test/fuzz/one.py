"""One reader under libFuzzer: `python -m test.fuzz.one READER CORPUS [-runs=N ...]`."""

from __future__ import annotations

import logging
import re
import sys
from pathlib import Path

import atheris

PACKAGE = Path(__file__).resolve().parents[2] / "trunk_ros"
KERNEL = re.compile(r"\bcompiled\(|^@compiled", re.MULTILINE)


def compiled_modules() -> list[str]:
    """Those that numba compiles, which it cannot once they are instrumented."""
    files = (file for file in PACKAGE.rglob("*.py") if KERNEL.search(file.read_text()))
    return [".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts) for file in files]


with atheris.instrument_imports(include=["trunk_ros", "mcap", "rosbags"], exclude=compiled_modules()):
    from test.fuzz.targets import TARGETS, attempt


def main(argv: list[str]) -> None:
    """Fuzz until libFuzzer's own options end it; it exits with 77 at the first failure."""
    logging.disable()
    name, corpus, *options = argv
    target, corpus_folder = TARGETS[name], Path(corpus)
    corpus_folder.mkdir(parents=True, exist_ok=True)
    for number, seed in enumerate(target.seeds()):
        (corpus_folder / f"seed_{number}").write_bytes(seed)
    atheris.Setup([name, corpus, *options], lambda data: attempt(target, data))
    atheris.Fuzz()


if __name__ == "__main__":
    main(sys.argv[1:])
