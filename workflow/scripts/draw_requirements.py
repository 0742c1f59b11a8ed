"""Rule draw_requirements: draw the margins of the required shocks."""

import csv

from snapmap.figures import requirements, style
from snapmap.io.job_log import job_log


def draw_requirements(csv_path, stem):
    """Draw the margin of each required shock, a row for each device and C; two columns wide."""
    with open(csv_path, newline="", encoding="utf-8") as file:
        verdicts = list(csv.DictReader(file))
    with style.paper():
        figure = style.double_column(height=1.2 + 0.32 * len(verdicts))
        requirements.draw_margins(figure.subplots(), verdicts)
        style.save(figure, stem, {"title": "Margins of required shocks"})


if __name__ == "__main__":
    with job_log(snakemake.log[0]):
        draw_requirements(
            csv_path=snakemake.input.requirements,
            stem=snakemake.output.pdf.removesuffix(".pdf"),
        )
