"""Break a room in small ways, and ask its own tests: a sign, a comparison, a constant, a lost term.

    ./run python tests/mutants.py thresholds --number 10 --seed 1

A room is a folder of the package, such as `values` or `applications/window`; its tests are those of
the same folder in `tests/`. Mutants are made in a copy of the clone.
"""

import argparse
import ast
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAIRS = (ast.Add, ast.Sub), (ast.Mult, ast.Div), (ast.Lt, ast.LtE), (ast.Gt, ast.GtE)
PAIRS += (ast.Eq, ast.NotEq), (ast.Is, ast.IsNot), (ast.In, ast.NotIn), (ast.And, ast.Or)
OTHER = {ast.Pow: ast.Mult, **dict(PAIRS), **{other: one for one, other in PAIRS}}
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


def places(tree: ast.AST) -> list[tuple[ast.AST, ast.AST]]:
    """List all mutants of a module: what stands there, and what comes in its place."""
    found = []
    for parent in ast.walk(tree):
        for field, value in ast.iter_fields(parent):
            if field not in ("annotation", "returns", "decorator_list", "slice"):
                children = value if isinstance(value, list) else [value]
                found += [(child, made) for child in children for made in mutants_of(child)]
    return found


class Exchanged(ast.NodeTransformer):
    """A module with another expression in place of one."""

    def __init__(self, before: ast.AST, made: ast.AST):
        """Take both."""
        self.before, self.made = before, made

    def visit(self, node: ast.AST) -> ast.AST:
        """Exchange the one, wherever it is."""
        return self.made if node is self.before else self.generic_visit(node)


def mutate(text: str, choice: int) -> tuple[str, str]:
    """Return a module with one of its mutants, and what was changed."""
    tree = ast.parse(text)
    before, made = places(tree)[choice]
    change = f"{before.lineno}: {ast.unparse(before)}  ->  {ast.unparse(made)}"
    mutant = Exchanged(before, made).visit(tree)
    return ast.unparse(ast.fix_missing_locations(mutant)), change


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
