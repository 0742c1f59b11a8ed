"""The notebook runs from top to bottom, and its numbers are those of the pages."""

import json

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest


def test_the_notebook_runs(root, tmp_path, monkeypatch):
    """Its code cells in turn, as nothing that shows a notebook is among the pinned packages."""
    mpl.use("agg")
    monkeypatch.chdir(tmp_path)
    text = (root / "examples" / "first_steps.ipynb").read_text(encoding="utf-8")
    cells = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
    assert not any(cell["outputs"] or cell["execution_count"] for cell in cells)
    names = {}
    for cell in cells:
        code = "".join(cell["source"])  # with fewer cells of the last two sweeps
        exec(code.replace("1900, 25", "1900, 9").replace("6000.0, 24", "6000.0, 5"), names)
        plt.close("all")
    assert names["run"].outcome == "snapped"
    assert names["run"].t_snap == pytest.approx(434.89, abs=0.02)
    found, own = names["found"].squeeze(), names["own"]
    assert (found.N_error < 0.01 * found.N_first).all()
    free, dragged = own.t_snap.notnull().mean("N").values
    assert (dragged <= free).all() and dragged.sum() < free.sum()  # drag asks for more N
    assert own.reproduced.mean() > 0.98
    below = found.N_first * 0.9 > own.N
    assert own.t_snap.sel(C=0.0).where(below).isnull().all()
