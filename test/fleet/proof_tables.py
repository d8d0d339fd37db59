"""``python -m test.fleet.proof_tables``: the together-analysis on full-size fleets of synthetic tables."""

from __future__ import annotations

import argparse
import sys

from test.concealed.fleet_tables import Score, changes_scored, made, trends_scored
from trunk_ros.fleet.together.series import collected
from trunk_ros.fleet.together.summary import Fleet, summarised

ARMS = RECORDINGS = 30


def read(seed: int, still: bool) -> Fleet:
    """What is said of one fleet."""
    arms = {f"arm_{k:02d}": RECORDINGS for k in range(ARMS)}
    return summarised(collected(made(seed, ARMS, RECORDINGS, still).rows, {}), arms, [])


def proof(fleets: int) -> dict[str, float]:
    """Scores over so many fleets with something hidden, and what is said of as many without."""
    trends = changes = Score(0, 0, 0)
    batch = found = false = 0
    for seed in range(fleets):
        table, fleet = made(seed, ARMS, RECORDINGS), read(seed, still=False)
        trends += trends_scored(table, fleet.trends)
        changes += changes_scored(table, fleet.changes)
        batch += len(table.batch)
        found += len({own.arm for own in fleet.own if own.effect == "ratio_error"} & set(table.batch))
        still = read(10_000 + seed, still=True)
        false += len(still.trends) + len(still.changes)
    return {
        "trends, F1": trends.f1,
        "changes, F1": changes.f1,
        "changes dated within one recording, share": changes.near / max(changes.right, 1),
        "arms of the odd batch that stand out, share": found / max(batch, 1),
        "trends and changes on fleets without any": false,
    }


def main(argv: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog="python -m test.fleet.proof_tables", description=__doc__)
    parser.add_argument("--fleets", type=int, default=30)
    for name, value in proof(parser.parse_args(argv).fleets).items():
        print(f"{name}: {value:.4g}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
