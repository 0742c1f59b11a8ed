"""Sizes of source: lines of code, lengths of functions and numbers of their parameters."""

import ast
import io
import tokenize

LAYOUT = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)


def code_lines(path):
    """Count lines of a file without those of blanks, comments and docstrings alone."""
    text = path.read_text(encoding="utf-8")
    docstrings, lines = set(), set()
    for node in ast.walk(ast.parse(text)):
        match node:
            case ast.Expr(value=ast.Constant(value=str())):
                docstrings.update(range(node.lineno, node.end_lineno + 1))
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in LAYOUT and token.type != tokenize.ENDMARKER:
            lines.update(range(token.start[0], token.end[0] + 1))
    return len(lines - docstrings)


def functions(path):
    """List the functions of a file: name, lines, and number of parameters but self and cls."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            args = node.args
            named = [each.arg for each in (*args.posonlyargs, *args.args, *args.kwonlyargs)]
            others = [name for name in named if name not in ("self", "cls")]
            yield node.name, node.end_lineno - node.lineno + 1, len(others)
