"""Only `portable` computes powers, exponentials and sines on the way to results."""

import ast
from itertools import chain

import numpy as np
import pytest
from small_studies import cases_of

from snapmap.numerics.portable import quarters

CASES = cases_of(__file__)
FUNCTIONS, ALLOWED = {*CASES["functions"]}, [*chain(*CASES["allowed"].values())]


def is_exact(node):
    """Whether a power is a square, or of literal numbers with a whole exponent."""
    try:
        power = ast.literal_eval(node.right)
    except ValueError:
        return False
    return isinstance(power, int) and (power in (0, 1, 2) or isinstance(node.left, ast.Constant))


def names(node):
    """What a node of a syntax tree takes from a library that rounds as it likes."""
    if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.MatMult):
        yield "@"
    if isinstance(node, ast.AugAssign) and isinstance(node.op, ast.Pow):
        yield "**="
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not is_exact(node):
        yield "**"
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        yield from {node.attr} & FUNCTIONS if node.value.id in ("np", "math") else ()
    if isinstance(node, ast.Import):
        yield from (each.name for each in node.names if each.name.startswith("scipy"))
    if isinstance(node, ast.ImportFrom) and node.module:
        library, imported = node.module.partition(".")[0], {each.name for each in node.names}
        yield from imported & FUNCTIONS if library in ("math", "numpy") else ()
        yield from imported if library == "scipy" else ()


def found(tree):
    """Pairs of a function or class at the top of a module, and of a name in it."""
    for top in tree.body:
        where = getattr(top, "name", "")
        yield from ((where, name) for node in ast.walk(top) for name in names(node))


def test_no_result_hangs_on_the_rounding_of_a_library(root):
    package = root / "workflow" / "scripts" / "snapmap"
    used = set()
    for path in sorted(package.rglob("*.py")):
        for where, name in found(ast.parse(path.read_text(encoding="utf-8"))):
            place = f"{path.relative_to(package).as_posix()}:{where}"
            reasons = {each for each in ALLOWED if place.startswith(each)}
            assert reasons, f"{place} uses {name}: write it with numerics/portable.py"
            used |= reasons
    assert used == {*ALLOWED}


@pytest.mark.parametrize("code", CASES["rounds"])
def test_what_rounds_by_the_machine_is_found(code):
    assert [*found(ast.parse(code))]


@pytest.mark.parametrize("code", CASES["exact"])
def test_what_is_exact_is_not(code):
    assert not [*found(ast.parse(code))]


def test_quarters_are_powers_of_the_fourth_root_of_two():
    powers = [quarters(n) for n in range(-12, 13)]
    assert powers[::4] == [2.0**n for n in range(-3, 4)]
    np.testing.assert_allclose(np.diff(np.log2(powers)), 0.25, rtol=1e-14)
