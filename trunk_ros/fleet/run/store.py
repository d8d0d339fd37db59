"""Results on disk as they come: small Parquet parts, put together at the end.

A part is written beside its place and moved there, so that a killed run leaves whole parts only.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from trunk_ros.errors import ArgumentError
from trunk_ros.fleet.inputs.listing import Job
from trunk_ros.fleet.run.outcome import OUTCOME, Row

FLUSH = 5.0  # s that a result may wait for the disk
MOST = 256  # results that may wait for it
PARTS = "parts"
KEPT = ["arm", "path", "content", "setting", "reason"]


class Store:
    """The outcomes of one kind of task in a folder: one row per path, the newest counts."""

    def __init__(self, folder: Path, name: str):
        """Raises ArgumentError where the folder cannot be used."""
        self.folder, self.name = folder, name
        self._waiting: list[Row] = []
        self._flushed = time.monotonic()
        try:
            (folder / PARTS).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ArgumentError(f"{folder} cannot be written: {error.strerror}") from None
        self._number = max((int(path.stem.rpartition("-")[2]) for path in self._parts()), default=0)
        self.known: dict[str, Row] = {}
        """What is done, by path, without its results."""
        self._with: dict[tuple[str, str], str] = {}
        """A path by content and setting."""
        for row in self.table().select(KEPT).to_pylist():
            self._note(row)

    def done(self, job: Job, content: str, setting: str, again: bool) -> bool:
        """Whether a recording with this content needs nothing more; ``again``: failed ones do."""
        row = self.known.get(job.path)
        if row is None or (again and row["reason"]):
            return False
        return bool((row["arm"], row["content"], row["setting"]) == (job.arm, content, setting))

    def add(self, row: Row) -> None:
        """Keep an outcome."""
        self._waiting.append(row)
        self._note({key: row[key] for key in KEPT})
        if len(self._waiting) >= MOST or time.monotonic() - self._flushed > FLUSH:
            self.flush()

    def _note(self, row: Row) -> None:
        self.known[row["path"]] = row
        if not row["reason"]:
            self._with[row["content"], row["setting"]] = row["path"]

    def flush(self) -> None:
        """Write what waits as a part."""
        if self._waiting:
            self._number += 1
            table = pa.Table.from_pylist(self._waiting, schema=OUTCOME)
            write(table, self.folder / PARTS / f"{self.name}-{self._number:06d}.parquet")
            self._waiting.clear()
        self._flushed = time.monotonic()

    def close(self) -> pa.Table:
        """Put all parts together in one file; returns what is in it."""
        self.flush()
        parts, whole = self._parts(), self.table()
        write(whole, self._whole)
        for part in parts:
            part.unlink(missing_ok=True)
        return whole

    def table(self) -> pa.Table:
        """All outcomes, the newest of each path."""
        files = ([self._whole] if self._whole.exists() else []) + self._parts()
        tables = [table for file in files if (table := _read(file)) is not None]
        joined = pa.concat_tables([OUTCOME.empty_table(), *tables])
        newest = {path: number for number, path in enumerate(joined["path"].to_pylist())}
        return joined.take(pa.array(sorted(newest.values()), pa.int64()))

    def of_content(self, content: str, setting: str) -> Row | None:
        """The outcome of whatever path has had the same content."""
        path = self._with.get((content, setting))
        if path is None:
            return None
        self.flush()
        table = self.table()
        found: list[Row] = table.filter(pc.equal(table["path"], path)).to_pylist()
        return found[0] if (found[0]["content"], found[0]["setting"]) == (content, setting) else None

    @property
    def _whole(self) -> Path:
        return self.folder / f"{self.name}.parquet"

    def _parts(self) -> list[Path]:
        return sorted((self.folder / PARTS).glob(f"{self.name}-*.parquet"))


def _read(file: Path) -> pa.Table | None:
    """A file of the store; what a full disk or another program left of it is done again."""
    try:
        table = pq.read_table(file)
        return table.select(OUTCOME.names).cast(OUTCOME)
    except (pa.ArrowException, OSError, KeyError, ValueError):
        return None


def write(table: pa.Table, path: Path) -> None:
    """Write a table, whole or not at all. Raises ArgumentError where that fails."""
    draft = path.with_name(f".{path.name}")
    try:
        pq.write_table(table, draft, compression="zstd")
        draft.replace(path)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise ArgumentError(f"{path} cannot be written: {error}") from None


def flat(outcomes: pa.Table, inside: str, columns: tuple[str, ...]) -> pa.Table:
    """The entries of a nested column as rows, each with its recording's own columns."""
    lists = outcomes[inside].combine_chunks()
    lists = lists.chunk(0) if isinstance(lists, pa.ChunkedArray) else lists
    of, entries = pc.list_parent_indices(lists), pc.list_flatten(lists)
    chosen = {
        name: outcomes[name].take(of) if name in outcomes.column_names else pc.struct_field(entries, name)
        for name in columns
    }
    return pa.table(chosen)


def rows(table: pa.Table) -> Iterator[dict[str, Any]]:
    """Rows of a table, a batch at a time."""
    for batch in table.to_batches(max_chunksize=4096):
        yield from batch.to_pylist()
