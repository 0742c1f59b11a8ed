"""Rows of requirements.csv, read back."""

from pathlib import Path

import pandas as pd

NAMES = ("requirement", "device")


def read_rows(path: str | Path) -> list[dict]:
    """Read the rows as they were written: a name stays text, were it 12 or nan."""
    text = pd.read_csv(path, dtype=str, keep_default_na=False)
    for key in text.columns.difference(NAMES):
        numbers = pd.to_numeric(text[key], errors="coerce")
        if (numbers.notna() | (text[key] == "nan")).all():
            text[key] = numbers
        elif text[key].isin(["True", "False"]).all():
            text[key] = text[key] == "True"
    return text.to_dict("records")
