"""What a Python file imports, read from its syntax tree: nothing is run."""

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def modules(folder: str) -> list[Path]:
    """Python files below a folder of the repository."""
    return sorted((ROOT / folder).rglob("*.py"))


def imported(path: Path) -> set[str]:
    """Dotted names that a file imports anywhere in it; `from a import b` counts as a and as a.b."""
    found = (name for node in ast.walk(ast.parse(path.read_text())) for name in _names(node, path))
    return set(found)


def _names(node: ast.AST, path: Path) -> Iterator[str]:
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        above = path.relative_to(ROOT).parts[: -node.level] if node.level else ()
        module = ".".join([*above, *filter(None, [node.module])])
        yield from (module, *(f"{module}.{alias.name}" for alias in node.names))
    elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "__import__")):
        yield from (arg.value for arg in node.args[:1] if isinstance(arg, ast.Constant))


def reached(paths: list[Path]) -> set[str]:
    """All that the files import, and what the repository's own modules among it import in turn."""
    names: set[str] = set()
    waiting = set().union(*map(imported, paths))
    while waiting:
        name = waiting.pop()
        names.add(name)
        waiting |= set().union(*map(imported, _files(name))) - names
    return names


def _files(name: str) -> list[Path]:
    """The file of a module of the repository, and the __init__.py of the packages that it is in."""
    base = ROOT.joinpath(*name.split("."))
    if base.is_relative_to(ROOT / "trunk_ros") or base.is_relative_to(ROOT / "test"):
        return [path for path in (base.with_suffix(".py"), base / "__init__.py") if path.is_file()]
    return []


def within(names: set[str], *packages: str) -> list[str]:
    """Those of the names that are one of the packages or below it."""
    return sorted(name for name in names for package in packages if f"{name}.".startswith(f"{package}."))
