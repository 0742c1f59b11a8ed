"""CSV tables: separators, units, words, bounds, and lines that name the fault."""

import numpy as np
import pandas as pd
import pytest
from small_studies import cases_of

from snapmap.files.named import read_named
from snapmap.files.tables import ANSWERS, SHOCKS, read_table, write_table

CASES = cases_of(__file__)
WORDS = {"tripped": ANSWERS, "name": None}


@pytest.mark.parametrize(("text", "how", "columns"), CASES["read"])
def test_columns_are_separated_as_the_header_is_and_count_in_its_units(text, how, columns):
    read = read_table(text.encode(), SHOCKS, **{"words": WORDS} | how)
    np.testing.assert_equal({key: column.tolist() for key, column in read.items()}, columns)


@pytest.mark.parametrize(("text", "how", "fault"), CASES["wrong"])
def test_a_fault_of_a_table_is_a_line_with_its_place(text, how, fault):
    with pytest.raises(ValueError, match=rf"\A{fault}"):
        read_table(text.encode(), SHOCKS, **{"words": WORDS} | how)


def test_answers_of_python_are_those_of_a_table():
    assert [ANSWERS[word] for word in (0, 1, False, True)] == [False, True] * 2


def test_a_table_is_written_with_units_in_as_many_digits_as_errors_allow(tmp_path):
    made = {"N": [1 / 3, np.nan], "f0": [1 / 3, 2.0], "to": ["+z", "a+"], "is_met": [True, False]}
    write_table(pd.DataFrame(made), tmp_path / "made.csv", {"f0": "Hz"}, exact=["f0"])
    lines = "N,f0 (Hz),to,is_met", "0.333333,0.3333333333333333,along +z,True", ",2.0,a+,False"
    assert (tmp_path / "made.csv").read_text().split("\n") == [*lines, ""]


def test_a_file_is_read_up_to_its_largest_size(tmp_path):
    (tmp_path / "table.csv").write_bytes(b"1" * 3_000_000)
    assert read_named(tmp_path / "table.csv", 3_000_000, "write less") == b"1" * 3_000_000
    with pytest.raises(ValueError, match=r"^has 3 MB; write less$"):
        read_named(tmp_path / "table.csv", 2_999_999, "write less")
