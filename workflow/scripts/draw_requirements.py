"""Rule draw_requirements: draw the margins of the required shocks."""

import pandas as pd

from snapmap.figures import requirements, style
from snapmap.io.job_log import run_rule


def draw_requirements(requirements_path, stem):
    """Draw the margin of each required shock, a row for each device and C; two columns wide."""
    # A name stays as it is, were it 12 or nan.
    names, numbers = ("requirement", "device"), ("margin", "margin_error")
    verdicts = pd.read_csv(
        requirements_path,
        dtype=dict.fromkeys(names, str),
        na_values=dict.fromkeys(numbers, "nan"),
        keep_default_na=False,
    ).to_dict("records")
    with style.paper():
        figure = style.double_column(height=1.2 + 0.32 * len(verdicts))
        requirements.draw_margins(figure.subplots(), verdicts)
        style.save(figure, stem, {"title": "Margins of required shocks"})


if __name__ == "__main__":
    run_rule(draw_requirements, snakemake)
