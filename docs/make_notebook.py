"""Run examples/first_steps.ipynb and store its texts and small pictures in it.

./run python docs/make_notebook.py
"""

import ast
import base64
import io
from contextlib import redirect_stdout
from pathlib import Path

import matplotlib.pyplot as plt
import nbformat
from nbformat.v4 import new_output

NOTEBOOK = Path(__file__).parents[1] / "examples" / "first_steps.ipynb"
DPI = 75
"""Of the stored pictures: git keeps each of them for ever."""


def main():
    """Run all cells in turn, and write the notebook where it was."""
    notebook = nbformat.read(NOTEBOOK, 4)
    plt.switch_backend("agg")
    run(notebook)
    nbformat.validate(notebook)
    nbformat.write(notebook, NOTEBOOK)


def run(notebook, names=None):
    """Run the code cells of a notebook, and replace their outputs; returns all figures' axes.

    names: the namespace of the cells
    """
    names, axes = {} if names is None else names, []
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    for number, cell in enumerate(cells, 1):
        cell.execution_count, cell.outputs = number, run_cell(cell.source, number, names)
        axes += [ax for figure in map(plt.figure, plt.get_fignums()) for ax in figure.axes]
        plt.close("all")
    return axes


def run_cell(source, number, names):
    """Run a cell as Jupyter would; returns its printed text, its last value, and its figures."""
    tree = ast.parse(source)
    is_shown = isinstance(tree.body[-1], ast.Expr) and not source.endswith(";")
    last = ast.Expression(tree.body.pop().value) if is_shown else None
    outputs, value = [], None
    with redirect_stdout(io.StringIO()) as printed:
        exec(compile(tree, "cell", "exec"), names)
        if last:
            value = eval(compile(last, "cell", "eval"), names)
    if printed.getvalue():
        outputs.append(new_output("stream", name="stdout", text=printed.getvalue()))
    if value is not None:
        data = {"text/plain": repr(value)}
        if hasattr(value, "_repr_html_"):
            data["text/html"] = value._repr_html_()
        outputs.append(new_output("execute_result", data, execution_count=number))
    return outputs + [picture(plt.figure(figure)) for figure in plt.get_fignums()]


def picture(figure):
    """Give a figure as the output of a cell."""
    file = io.BytesIO()
    figure.savefig(file, dpi=DPI, bbox_inches="tight", metadata={"Software": None})
    data = {"image/png": base64.b64encode(file.getvalue()).decode(), "text/plain": "<Figure>"}
    return new_output("display_data", data)


if __name__ == "__main__":
    main()
