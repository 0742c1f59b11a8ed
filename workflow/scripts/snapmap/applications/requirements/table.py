"""The table of verdicts."""

import csv
from collections.abc import Sequence
from itertools import chain
from math import nan

from ...files.atomic import replacing
from ...study.study import Study
from ..histories.history import Extremes
from .check import Survival, Verdict, summary, worst
from .required import Required
from .verdicts import hint


def write_verdicts(study: Study, requirements: Sequence[Required], path: str) -> None:
    """Judge requirements, and write a row for each device, corner and C; prints the worst.

    study: a `Config`
    """
    C = study.axes["C"].tolist()
    judged = [pair for required in requirements for pair in required.check(study, C)]
    verdicts = [verdict for verdict, _ in judged]
    wrong, words = worst(verdicts)
    words = [summary(verdicts), words]
    if wrong:
        shocks = [one.values for one in requirements if "shocks" in one.values]
        how = study.temperatures, study.threshold_tolerance
        words.append(hint(study, shocks, verdicts, wrong, *how))
    always = chain(*(one._fields for one in (Verdict, Extremes, Survival)))
    columns = dict.fromkeys(chain(always, *(beside for _, beside in judged)))
    with replacing(path) as part, open(part, "w", newline="", encoding="utf-8") as file:
        rows = csv.DictWriter(file, columns, restval=nan)
        rows.writeheader()
        for verdict, beside in judged:
            rows.writerow(verdict._asdict() | beside)
    print(f"{path}: {'; '.join(filter(None, words))}")
