"""Writes the table at the end of docs/theory.md: each equation, and the tests that name it.

./run python docs/make_equations.py

A test names the equations that it asserts by @pytest.mark.equation(4, 13).
"""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "theory.md"
HEADING = "\n## Tests of the equations\n"
INTRO = """
These tests assert the equations, or what follows from them: `./run pytest -m equation`.

| equation | tests, below `tests/` |
|---|---|
"""
HANDOUT = range(1, 6)
"""Numbers of the equations that are the handout's, whether or not the page repeats them."""


def numbered(page: str) -> set[int]:
    """Return the numbers of the page's equations."""
    return {*HANDOUT, *map(int, re.findall(r"\((\d+)\)\$\$$", page, re.M))}


def named() -> dict[int, list[str]]:
    """Return the tests that name each equation, as FILE::TEST."""
    tests = {}
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            for mark in getattr(node, "decorator_list", []):
                if ast.unparse(mark).startswith("pytest.mark.equation("):
                    file = path.relative_to(ROOT / "tests").as_posix()
                    for number in mark.args:
                        tests.setdefault(number.value, []).append(f"`{file}::{node.name}`")
    return tests


def complete(page: str) -> str:
    """Return the page with the table made anew."""
    rows = (f"| ({number}) | {', '.join(tests)} |\n" for number, tests in sorted(named().items()))
    return page.partition(HEADING)[0] + HEADING + INTRO + "".join(rows)


if __name__ == "__main__":
    PAGE.write_text(complete(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
