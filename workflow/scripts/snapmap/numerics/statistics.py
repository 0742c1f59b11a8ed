"""Shares with their bounds, in numbers and in words; the same everywhere."""

import numpy as np

DEVIATIONS = 1.959963984540054
"""Standard deviations about the mean within which 95 % of a normal distribution lie."""


def percents(*shares: float) -> str:
    """A share in per cent, or from the lowest of some to the highest: once if both read alike."""
    ends = dict.fromkeys(f"{100 * float(end):.1f}" for end in (min(shares), max(shares)))
    return f"{' to '.join(ends)} %"


def scope(share) -> str:
    """Say at which temperatures a yield counts, and what it leaves out, by its attributes.

    share: a DataArray of yields, as in the dataset of tolerances
    """
    words = {"temperatures": "at", "leaves_out": "without"}
    return "".join(
        f", {word} {share.attrs[key]}" for key, word in words.items() if key in share.attrs
    )


def wilson(count: np.ndarray, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Bounds at 95 % of the share that `count` of so many samples stand for (Wilson, 1927)."""
    z2 = DEVIATIONS * DEVIATIONS
    share = np.asarray(count) / samples
    middle = (share + z2 / (2 * samples)) / (1 + z2 / samples)
    spread = share * (1 - share) / samples + z2 / (4 * samples * samples)
    half = DEVIATIONS * np.sqrt(spread) / (1 + z2 / samples)
    return np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)
