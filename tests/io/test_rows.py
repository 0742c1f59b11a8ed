"""Rows of requirements.csv come back as they were written."""

from snapmap.io.rows import read_rows


def test_names_stay_text_and_numbers_are_numbers(tmp_path):
    path = tmp_path / "requirements.csv"
    lines = [
        "requirement,device,margin,must_snap,verdict,must_survive",
        "nan,12,nan,True,met,0.999",
    ]
    path.write_text("\n".join([*lines, "b,,0.5,False,failed,nan"]) + "\n")
    first, second = read_rows(path)
    assert (first["requirement"], first["device"], second["device"]) == ("nan", "12", "")
    assert first["margin"] != first["margin"] and second["margin"] == 0.5
    assert (first["must_snap"], second["must_snap"], first["verdict"]) == (True, False, "met")
    assert second["must_survive"] != second["must_survive"]
