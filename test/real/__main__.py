"""``python -m test.real DIR``: this project beside a bank of plays, boosting and a network on real
recordings.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from threadpoolctl import threadpool_limits

from test.real.peers import PEERS
from test.real.sets import SETS
from test.real.table import compared, written


def main() -> None:
    """One table a set."""
    parser = argparse.ArgumentParser(prog="python -m test.real", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="DIR", help="the folder with the sets' folders in it")
    parser.add_argument("--only", default="", metavar="SET", help="folders whose name begins so")
    parser.add_argument(
        "--peers", nargs="*", choices=tuple(PEERS), default=tuple(PEERS), help="what to compare with"
    )
    parser.add_argument(
        "--all-rows",
        action="store_true",
        help="count every row, also where a camera lost its markers (0 there)",
    )
    arguments = parser.parse_args()
    cells = reached = 0
    for real in SETS:
        if not real.folder.startswith(arguments.only) or not (arguments.folder / real.folder).is_dir():
            continue
        with threadpool_limits(1):
            rows = compared(real, arguments.folder, arguments.peers, arguments.all_rows)
        print(written(real, rows), flush=True)
        print(flush=True)
        cells += len(rows)
        reached += sum(row.reached for row in rows)
    print(f"{reached} of {cells} cells at most 5 % above the best of the others")


if __name__ == "__main__":
    main()
