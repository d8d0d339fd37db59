"""One reader under libFuzzer: `python -m test.fuzz.one READER CORPUS [-runs=N ...]`."""

from __future__ import annotations

import logging
import sys
from pathlib import Path

import atheris

with atheris.instrument_imports(
    include=[
        "trunk_ros.recording",
        "trunk_ros.model",
        "trunk_ros.arm.parameters",
        "trunk_ros.trajectory",
        "mcap",
    ]
):
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
