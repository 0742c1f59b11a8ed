"""Shares and their confidence bounds, as numbers and as text."""

import numpy as np

DEVIATIONS = 1.959963984540054
"""Half the width of the interval that holds 95 % of a normal distribution, over its deviation."""
CONFIDENCE = 0.95
"""Default confidence of each bound of a share."""
DECIMALS = 7
"""Decimals to which bounds are rounded, so that libraries cannot differ."""
MOST = 10_000_000
"""Most samples that are counted on."""


def percents(*shares: float) -> str:
    """Write shares in per cent, from the lowest to the highest, or once if both read alike.

    NaN is not known, and not counted among others.
    """
    known = [100 * float(share) for share in shares if share == share]
    if not known:
        return "not known"
    ends = dict.fromkeys(map(_percent, (min(known), max(known))))
    return f"{' to '.join(ends)} %"


def _percent(end):
    """Write per cent to a tenth, or as finely as it takes to tell them from 0 and 100."""
    apart = round(min(abs(end), abs(100 - end)), DECIMALS - 2)
    digits, finest = 1, 10.0
    while 0 < apart * finest < 1:
        digits, finest = digits + 1, 10 * finest
    return f"{end:.{digits}f}"


def scope(share) -> str:
    """Write at which temperatures a yield holds and what it leaves out, from its attributes.

    share: DataArray of yields, as in the dataset of tolerances
    """
    words = {"temperatures": "at", "leaves_out": "without"}
    return "".join(
        f", {word} {share.attrs[key]}" for key, word in words.items() if key in share.attrs
    )


def share_bounds(
    count: np.ndarray, samples: int, confidence: float | np.ndarray = CONFIDENCE
) -> tuple[np.ndarray, np.ndarray]:
    """Return the bounds of a share of samples by their count, each alone at a confidence.

    The bounds are those of Clopper and Pearson (1934). A count may be a sum of probabilities.
    """
    from scipy.stats import beta  # half a second, for which no config that is read has to wait

    count, confidence = np.asarray(count, float), np.asarray(confidence)
    with np.errstate(invalid="ignore"):
        low = beta.ppf(1 - confidence, count, samples - count + 1)
        high = beta.ppf(confidence, count + 1, samples - count)
    low, high = np.where(count > 0, low, 0.0), np.where(count < samples, high, 1.0)
    return np.round(low, DECIMALS), np.round(high, DECIMALS)


def devices_to_decide(share: float, asked: float, confidence: float = CONFIDENCE) -> float:
    """Find the least number of samples whose bounds decide whether a share reaches an asked one.

    The share is that of the samples; infinite if MOST are too few. A share of 1 reaches 99.9 % at
    95 % with 2995.
    """

    def decides(size):
        low, high = share_bounds(share * size, size, confidence)
        return low >= asked or high < asked

    few, enough = 0, MOST
    if not decides(enough):
        return np.inf
    while enough - few > 1:
        middle = (few + enough) // 2
        few, enough = (few, middle) if decides(middle) else (middle, enough)
    return enough
