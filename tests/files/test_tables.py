"""CSV tables: separators, words, bounds, and lines that name the fault."""

import pytest

from snapmap.files.named import read_named
from snapmap.files.tables import ANSWERS, SHOCKS, read_table

WORDS = {"tripped": ANSWERS}


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_columns_are_separated_as_the_header_is_and_words_have_any_case(separator):
    text = "N (g),f0,tripped\n900,2000,Yes\n\n800,1000,NO\n".replace(",", separator)
    table = read_table(text.encode(), SHOCKS, WORDS, above=0.0)
    assert table["N"].tolist() == [900.0, 800.0] and table["tripped"].tolist() == [True, False]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("N,tripped\n900,yes\n0,no\n", "line 3, column N: '0' is not a number above 0"),
        ("N,tripped\n900,maybe\n", "line 2, column tripped: 'maybe' is not yes or no"),
        ("N,N (g)\n900,900\n", "line 1: column N comes twice"),
        ("N,tripped\n" + "1,yes\n" * 4, "has more than 3 rows"),
    ],
)
def test_a_fault_of_a_table_is_a_line_with_its_place(text, fault):
    with pytest.raises(ValueError, match=rf"\A{fault}"):
        read_table(text.encode(), SHOCKS, WORDS, most=3, above=0.0)


def test_a_file_is_read_up_to_its_largest_size(tmp_path):
    (tmp_path / "table.csv").write_bytes(b"12345")
    assert read_named(tmp_path / "table.csv", 5, "write less") == b"12345"
    with pytest.raises(ValueError, match="write less"):
        read_named(tmp_path / "table.csv", 4, "write less")
