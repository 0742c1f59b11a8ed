"""The code that a script's products depend on: the script, all that it imports, and their data."""

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

OWN = "snapmap", "studies"
"""Packages of this project: where it is installed, others lie beside them."""


class Source(NamedTuple):
    """What a file says, but for comments and docstrings, and what it asks for.

    imports: (level, names) of each module that may be meant; strings: all in it
    """

    code: str
    imports: frozenset[tuple[int, tuple[str, ...]]] = frozenset()
    strings: frozenset[str] = frozenset()


def code_hash(script: str | Path, folder: str | Path | None = None) -> str:
    """Hash what a script or a module runs of this project; comments and docstrings apart.

    folder: as in `code_files`; returns 12 hex digits
    """
    digest, folder = hashlib.sha256(), Path(folder or _room(script)).resolve()
    for path in code_files(script, folder):
        digest.update(f"{path.relative_to(folder).as_posix()}\0{_source(path).code}\0".encode())
    return digest.hexdigest()[:12]


def code_files(script: str | Path, folder: str | Path | None = None) -> list[Path]:
    """Paths of the script, of the modules beside it that it reaches by imports, and of their data.

    Data is a file in a module's folder that the module names in a string.
    folder: where packages lie; if not given the script's own or, of a script without them, as in a
        wheel, this package's
    """
    script, folder = Path(script).resolve(), Path(folder or _room(script)).resolve()
    found, waiting = set(), [script]
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += _reached(path, folder, path.stat().st_mtime_ns)
    return sorted(found)


def _room(script):
    beside = Path(script).parent
    return beside if any((beside / name).is_dir() for name in OWN) else Path(__file__).parents[2]


@cache
def _reached(path, folder, changed):
    """Files that a file imports from below a folder, their packages', and its data.

    changed: when it was; scripts share most of their files, and each is looked through once
    """
    found = [path.parent / name for name in _data(path)]
    package = path.parent.relative_to(folder).parts
    for level, names in _source(path).imports:
        parts = (*package[: len(package) + 1 - level], *names) if level else names
        if parts[0] not in OWN:
            continue
        for length in range(1, len(parts) + 1):
            place = folder.joinpath(*parts[:length])
            found += filter(Path.is_file, (place / "__init__.py", place.with_suffix(".py")))
    return found


def _data(path):
    strings = _source(path).strings
    return [file.name for file in path.parent.iterdir() if file.suffix and file.name in strings]


def _source(path):
    return _parse(path.suffix, path.read_bytes())


@cache
def _parse(suffix, content):
    if suffix != ".py":
        return Source(hashlib.sha256(content).hexdigest())
    tree = ast.parse(content)
    nodes = list(_run_nodes(tree))
    imports = frozenset(found for node in nodes for found in _modules(node))
    strings = frozenset(node.value for node in nodes if _is_string(node))
    for node in nodes:
        if isinstance(body := getattr(node, "body", None), list):
            node.body = [part for part in body if not _is_words(part)]
    return Source(ast.dump(tree), imports, strings)


def _is_string(node):
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _is_words(statement):
    """Whether it is a docstring, or the words below a constant."""
    return isinstance(statement, ast.Expr) and _is_string(statement.value)


def _run_nodes(tree) -> Iterator[ast.AST]:
    """All nodes but those that only a type checker sees."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            waiting += node.orelse
        else:
            waiting += ast.iter_child_nodes(node)


def _modules(node):
    """Levels and names of the modules that a node imports; what is taken from one may be one."""
    if isinstance(node, ast.Import):
        return [(0, tuple(alias.name.split("."))) for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        names = tuple(node.module.split(".")) if node.module else ()
        return [(node.level, (*names, *rest)) for rest in [(), *((a.name,) for a in node.names)]]
    return []
