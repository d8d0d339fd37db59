"""Which files a result rests on: a module of this folder with all that it imports of it."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
ASIDE = ("nodes", "paper")  # of the package: no diagnosis rests on them


def _imported(file: Path) -> set[Path]:
    names: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module == "test.concealed":
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("test.concealed."):
            names.add(str(node.module).removeprefix("test.concealed."))
    return {HERE / f"{name}.py" for name in names}


def closure(*modules: str) -> set[Path]:
    """Files of the modules and of all that they import of this folder."""
    found: set[Path] = set()
    todo = {HERE / f"{name}.py" for name in modules}
    while todo:
        found |= todo
        todo = {one for file in todo for one in _imported(file)} - found
    return found


def digest(files: Iterable[Path]) -> str:
    """Short hash of the files, names and contents."""
    total = hashlib.sha256()
    for file in sorted(files):
        total.update(file.relative_to(ROOT).as_posix().encode() + file.read_bytes())
    return total.hexdigest()[:12]


def package() -> set[Path]:
    """Files of the package and its nominal arm that a diagnosis may rest on."""
    own = ROOT / "trunk_ros"
    code = {f for f in own.rglob("*.py") if f.relative_to(own).parts[0] not in ASIDE}
    return code | set((ROOT / "config").glob("*.yaml"))


@cache
def marks_code() -> str:
    """Hash of package, plants, protocol and marks: marks of other code do not count."""
    return digest(package() | closure("seeds", "protocol", "solver", "marks", "removed"))


@cache
def others_code() -> str:
    """Hash of the plants and of what is compared with the diagnosis, which does not rest on the package."""
    return digest(closure("seeds", "others"))
