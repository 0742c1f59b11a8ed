"""How many shots show a reliability: the binomial law, as Clopper and Pearson invert it."""

from bisect import bisect_left

from scipy.stats import beta, binom, chi2


def shots_needed(reliability: float, confidence: float = 0.95, failures: int = 0) -> int:
    """How many shots show a reliability at a confidence, if so many of them may fail.

    reliability: least share of devices that do as required, from 0 to 1
    failures: none by default: a success run, ln(1 - confidence) / ln(reliability) shots

    >>> snapmap.shots_needed(0.999, 0.95)
    2995
    """
    # By Poisson's law it takes more.
    most = int(chi2.ppf(confidence, 2 * failures + 2) / 2 / (1 - reliability)) + failures + 2
    return bisect_left(
        range(most), confidence, key=lambda shots: confidence_shown(shots, failures, reliability)
    )


def confidence_shown(shots: int, failures: int, reliability: float) -> float:
    """The confidence at which shots with so many failures show a reliability."""
    return float(binom.sf(failures, shots, 1 - reliability))


def reliability_shown(shots: int, failures: int, confidence: float = 0.95) -> float:
    """The reliability that shots with so many failures show at a confidence, one-sided."""
    return float(beta.ppf(1 - confidence, shots - failures, failures + 1))
