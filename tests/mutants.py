"""Break a room in small ways, and ask its own tests: a sign, a comparison, a constant, a lost term.

    ./run python tests/mutants.py thresholds --number 10 --seed 1

A room is a folder of the package, such as `values` or `applications/window`; its tests are those of
the same folder in `tests/`. Mutants are made in a copy of the clone.
"""

import argparse
import ast
import copy
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OTHER = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Pow: ast.Mult,
}
OTHER |= {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq}
OTHER |= {ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn}
OTHER |= {ast.NotIn: ast.In, ast.And: ast.Or, ast.Or: ast.And, ast.Pow: ast.Mult}
SIGNS = ast.USub, ast.Not, ast.Invert
SLOWER = 10
"""Time after which a mutant counts as caught, over that of the tests without one."""


def mutants_of(node: ast.AST) -> list[ast.AST]:
    """Make what may stand in place of an expression; empty for most."""
    made = []
    match node:
        case ast.BinOp(left=ast.Constant(value=str())) | ast.BinOp(op=ast.BitOr()):
            pass  # joined text, and types such as `float | None`
        case ast.BinOp(op=op) if type(op) in OTHER:
            made = [ast.BinOp(node.left, OTHER[type(op)](), node.right)]
            if isinstance(op, ast.Add | ast.Sub):
                made += [node.left, node.right]
        case ast.BinOp(op=ast.BitAnd()):
            made = [node.left, node.right]
        case ast.Compare(ops=[op]) if type(op) in OTHER:
            made = [ast.Compare(node.left, [OTHER[type(op)]()], node.comparators)]
        case ast.BoolOp():
            made = [ast.BoolOp(OTHER[type(node.op)](), node.values), *node.values]
        case ast.UnaryOp(op=op) if isinstance(op, SIGNS):
            made = [node.operand]
        case ast.Constant(value=bool(value)):
            made = [ast.Constant(not value)]
        case ast.Constant(value=int(value)):
            made = [ast.Constant(value + 1)]
        case ast.Constant(value=float(value)):
            made = [ast.Constant(2 * value if value else 1.0)]
    return made


def places(tree: ast.AST) -> list[tuple[ast.AST, str, int | None, ast.AST]]:
    """List all mutants of a module: parent, its field and index there, and what comes there."""
    found = []
    for parent in ast.walk(tree):
        for field, value in ast.iter_fields(parent):
            if field in ("annotation", "returns", "decorator_list", "slice"):
                continue
            children = value if isinstance(value, list) else [value]
            for at, child in enumerate(children):
                index = at if isinstance(value, list) else None
                found += [(parent, field, index, made) for made in mutants_of(child)]
    return found


def mutate(text: str, choice: int) -> tuple[str, str]:
    """Return a module with one of its mutants, and what was changed."""
    tree = ast.parse(text)
    parent, field, index, made = places(tree)[choice]
    held = getattr(parent, field)
    before = held if index is None else held[index]
    change = f"{before.lineno}: {ast.unparse(before)}  ->  {ast.unparse(copy.copy(made))}"
    if index is None:
        setattr(parent, field, made)
    else:
        held[index] = made
    return ast.unparse(ast.fix_missing_locations(tree)), change


def passes(clone: Path, room: str, limit: float | None = None) -> bool:
    """Tell whether a room's own tests pass in a clone within a limit, s."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-n0", f"tests/{room}"]
    variables = os.environ | {"PYTHONPATH": str(clone / "workflow" / "scripts")}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    try:
        done = subprocess.run(command, cwd=clone, env=variables, timeout=limit, **quiet)
        return done.returncode == 0
    except subprocess.TimeoutExpired:
        return False


def main() -> None:
    """Print each mutant that survives, and how many were caught."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("rooms", nargs="+")
    parser.add_argument("--number", type=int, default=10, help="mutants of each room")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        clone = Path(folder, "clone")
        subprocess.run(["git", "clone", "--quiet", ROOT, clone], check=True)
        for room in options.rooms:
            try_room(clone, room, options.number, random.Random(f"{options.seed} {room}"))


def try_room(clone: Path, room: str, number: int, draw: random.Random) -> None:
    """Draw mutants of a room, run its tests on each, and print what survives."""
    begun = time.monotonic()
    if not passes(clone, room):
        sys.exit(f"tests/{room}: fails or is missing without a mutant")
    limit = SLOWER * (time.monotonic() - begun)
    package = clone / "workflow" / "scripts" / "snapmap"
    files = sorted({*package.glob(f"{room}.py"), *package.glob(f"{room}/**/*.py")})
    texts = {path: path.read_text(encoding="utf-8") for path in files}
    choices = [(path, at) for path in files for at in range(len(places(ast.parse(texts[path]))))]
    drawn = draw.sample(choices, min(number, len(choices)))
    caught = 0
    for path, at in drawn:
        mutant, change = mutate(texts[path], at)
        path.write_text(mutant, encoding="utf-8")
        if passes(clone, room, limit):
            print(f"  survives  {path.relative_to(package)}:{change}", flush=True)
        else:
            caught += 1
        path.write_text(texts[path], encoding="utf-8")
    print(f"{room}: {caught} of {len(drawn)} caught", flush=True)


if __name__ == "__main__":
    main()
