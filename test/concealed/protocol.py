"""Conceal, then reveal: the answer lies encrypted apart from the recordings, its salted hash in the open.

``OPEN/<id>/run_1`` and ``run_2`` are the recordings; ``OPEN/<id>/commitment.json`` the hash of the answer;
``SEALED/<id>.sealed`` the answer with its salt. Its key stays in the memory of the process that concealed,
which is never the one that diagnoses. The id is drawn, it tells nothing of the case.
"""

from __future__ import annotations

import base64
import hashlib
import json
import secrets
import zlib
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
    """Where a concealed case lies, the open folder and the sealed file; the key; the hash that was
    promised.
    """

    folder: Path
    sealed: Path
    key: bytes
    promised: str


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


def _stirred(key: bytes, text: bytes) -> bytes:
    """Text and a key stream of its length, bit by bit unlike or not; the same again gives the text back."""
    stream = hashlib.shake_256(key).digest(len(text))
    return (int.from_bytes(text) ^ int.from_bytes(stream)).to_bytes(len(text))


def seal(path: Path, key: bytes, salt: str, answer: dict[str, Any]) -> None:
    """Write an answer and its salt, encrypted."""
    path.write_bytes(_stirred(key, zlib.compress(json.dumps({"salt": salt, "answer": answer}).encode())))


def unsealed(path: Path, key: bytes) -> tuple[str, dict[str, Any]]:
    """Salt and answer of a sealed file. Raises BrokenSealError where it is none, or the key is another."""
    try:
        both = json.loads(zlib.decompress(_stirred(key, path.read_bytes())))
        return str(both["salt"]), dict(both["answer"])
    except (ValueError, zlib.error, KeyError) as error:
        raise BrokenSealError(f"{path.name} is damaged, or this is not its key: {error}") from error


def conceal(case: Case, open_folder: Path, sealed_folder: Path) -> Concealed:
    """Writes the recordings and the hash of the answer in the open, the answer sealed."""
    name = secrets.token_hex(6)
    folder, sealed = open_folder / name, sealed_folder / f"{name}.sealed"
    folder.mkdir(parents=True)
    sealed_folder.mkdir(parents=True, exist_ok=True)
    for run, motion in (("run_1", case.train), ("run_2", case.test)):
        write_bag(motion, folder / run, secrets.randbits(32))
    clean = base64.b64encode(np.ascontiguousarray(case.test.theta_clean, "<f8").tobytes()).decode()
    answer = {"told": case.told(), "clean": clean, "recordings": _recordings(folder)}
    salt = secrets.token_hex(32)
    where = Concealed(folder, sealed, secrets.token_bytes(32), _digest(salt, answer))
    seal(sealed, where.key, salt, answer)
    open_text = json.dumps({"algorithm": "sha256(salt, answer)", "hash": where.promised})
    (folder / "commitment.json").write_text(open_text)
    return where


def reveal(where: Concealed) -> Answer:
    """Opens the answer. Raises BrokenSealError where it, its salt or a recording was changed."""
    salt, answer = unsealed(where.sealed, where.key)
    told = json.loads((where.folder / "commitment.json").read_text())["hash"]
    if not told == where.promised == _digest(salt, answer):
        raise BrokenSealError(f"{where.sealed.name} is not the answer that was promised: its hash differs")
    if answer["recordings"] != _recordings(where.folder):
        raise BrokenSealError(f"the recordings in {where.folder.name} are not those of the sealed answer")
    clean = np.frombuffer(base64.b64decode(answer["clean"]), "<f8").reshape(-1, COUNT)
    return Answer(answer["told"], clean)
