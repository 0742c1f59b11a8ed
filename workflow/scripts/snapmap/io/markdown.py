"""Tables of the report."""

from collections.abc import Iterable, Sequence

DASH = "–"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table, all columns but the first aligned to the right; short rows are filled."""
    rule = [":--"] + ["--:"] * (len(head) - 1)
    filled = [[*row, *[DASH] * (len(head) - len(row))] for row in rows]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in (head, rule, *filled))


def number(value: float) -> str:
    """Three significant digits, thousands apart: 5 140, 0.61."""
    return f"{float(f'{value:.3g}'):,}".removesuffix(".0").replace(",", " ")


def rate(count: int, seconds: float) -> str:
    """How many in a second."""
    return number(count / seconds)


def ratio(value: float) -> str:
    """Times as much, or the inverse of it: 12.3, 1/420."""
    return number(value) if value >= 1 else f"1/{number(1 / value)}"
