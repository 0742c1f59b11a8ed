"""Rule draw_requirements: draw the margins of the required shocks."""

from snapmap.figures import requirements, style
from snapmap.io.job_log import run_rule
from snapmap.io.rows import read_rows


def draw_requirements(requirements_path, stem):
    """Draw the margin of each required shock, a row for each device and C; two columns wide."""
    verdicts = read_rows(requirements_path)
    with style.paper():
        figure = style.double_column(height=1.2 + 0.32 * len(verdicts))
        requirements.draw_margins(figure.subplots(), verdicts)
        style.save(figure, stem, {"title": "Margins of required shocks"})


if __name__ == "__main__":
    run_rule(draw_requirements, snakemake)
