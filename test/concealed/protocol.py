"""Conceal, then reveal: the answer lies sealed apart from the recordings, its salted hash in the open.

``OPEN/<id>/run_1`` and ``run_2`` are the recordings; ``OPEN/<id>/commitment.json`` the hash of the answer;
``SEALED/<id>.sealed`` the answer with its salt. The id is drawn, it tells nothing of the case.
"""

from __future__ import annotations

import base64
import hashlib
import json
import secrets
import sys
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from test.concealed.bag import write_bag
from test.concealed.case import Case
from test.concealed.nominal import COUNT, Array


class BrokenSealError(Exception):
    """An answer, its hash and the recordings do not belong together."""


@dataclass(frozen=True)
class Concealed:
    """Where a concealed case lies: the open folder and the sealed file."""

    folder: Path
    sealed: Path


@dataclass(frozen=True)
class Answer:
    """``told`` as in truth.json; ``clean`` (n, 5) rad: the noise-free joint angle of run_2."""

    told: dict[str, Any]
    clean: Array


def _digest(salt: str, answer: dict[str, Any]) -> str:
    text = json.dumps(answer, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(f"{salt}\n{text}".encode()).hexdigest()


def _recordings(folder: Path) -> dict[str, str]:
    """Hash of every file of the recordings, so that none can be exchanged."""
    files = sorted(f for run in ("run_1", "run_2") for f in (folder / run).rglob("*") if f.is_file())
    return {str(f.relative_to(folder)): hashlib.sha256(f.read_bytes()).hexdigest() for f in files}


def seal(path: Path, salt: str, answer: dict[str, Any]) -> None:
    """Write an answer and its salt, compressed, so that no search for a word finds it."""
    packed = zlib.compress(json.dumps({"salt": salt, "answer": answer}).encode())
    path.write_bytes(base64.b64encode(packed))


def unsealed(path: Path) -> tuple[str, dict[str, Any]]:
    """Salt and answer of a sealed file. Raises BrokenSealError where it is none."""
    try:
        both = json.loads(zlib.decompress(base64.b64decode(path.read_bytes(), validate=True)))
        return str(both["salt"]), dict(both["answer"])
    except (ValueError, zlib.error, KeyError) as error:
        raise BrokenSealError(f"{path.name} is damaged: {error}") from error


def conceal(case: Case, open_folder: Path, sealed_folder: Path) -> Concealed:
    """Writes the recordings and the hash of the answer in the open, the answer sealed."""
    name = secrets.token_hex(6)
    where = Concealed(open_folder / name, sealed_folder / f"{name}.sealed")
    where.folder.mkdir(parents=True)
    sealed_folder.mkdir(parents=True, exist_ok=True)
    for run, motion in (("run_1", case.train), ("run_2", case.test)):
        write_bag(motion, where.folder / run, secrets.randbits(32))
    clean = base64.b64encode(np.ascontiguousarray(case.test.theta_clean, "<f8").tobytes()).decode()
    answer = {"told": case.told(), "clean": clean, "recordings": _recordings(where.folder)}
    salt = secrets.token_hex(32)
    seal(where.sealed, salt, answer)
    open_text = json.dumps({"algorithm": "sha256(salt, answer)", "hash": _digest(salt, answer)})
    (where.folder / "commitment.json").write_text(open_text)
    return where


def reveal(where: Concealed) -> Answer:
    """Opens the answer. Raises BrokenSealError where it, its salt or a recording was changed."""
    salt, answer = unsealed(where.sealed)
    promised = json.loads((where.folder / "commitment.json").read_text())["hash"]
    if not secrets.compare_digest(promised, _digest(salt, answer)):
        raise BrokenSealError(f"{where.sealed.name} is not the answer that was promised: its hash differs")
    if answer["recordings"] != _recordings(where.folder):
        raise BrokenSealError(f"the recordings in {where.folder.name} are not those of the sealed answer")
    clean = np.frombuffer(base64.b64decode(answer["clean"]), "<f8").reshape(-1, COUNT)
    return Answer(answer["told"], clean)


_shut: list[Path] = []


def _refuse(event: str, arguments: tuple[Any, ...]) -> None:
    if not _shut or event != "open" or not isinstance(arguments[0], str):
        return
    path = Path(arguments[0]).absolute()
    if any(path.is_relative_to(folder) for folder in _shut):
        raise BrokenSealError(f"{path.name} was opened during the diagnosis")


@contextmanager
def kept_shut(sealed_folder: Path) -> Iterator[None]:
    """While this lasts, nothing in this process can open a sealed answer."""
    if not getattr(kept_shut, "hooked", False):
        sys.addaudithook(_refuse)  # stays for the life of the process
        kept_shut.hooked = True  # type: ignore[attr-defined]
    _shut.append(sealed_folder.absolute())
    try:
        yield
    finally:
        _shut.pop()
