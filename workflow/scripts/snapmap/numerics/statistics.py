"""Shares and their confidence bounds, as numbers and as text."""

import numpy as np

DEVIATIONS = 1.959963984540054
"""Half the width of the interval that holds 95 % of a normal distribution, over its deviation."""


def percents(*shares: float) -> str:
    """Write shares in per cent, from the lowest to the highest, or once if both read alike.

    NaN is not known, and not counted among others.
    """
    known = [100 * float(share) for share in shares if share == share]
    if not known:
        return "not known"
    ends = dict.fromkeys(f"{end:.1f}" for end in (min(known), max(known)))
    return f"{' to '.join(ends)} %"


def scope(share) -> str:
    """Write at which temperatures a yield holds and what it leaves out, from its attributes.

    share: DataArray of yields, as in the dataset of tolerances
    """
    words = {"temperatures": "at", "leaves_out": "without"}
    return "".join(
        f", {word} {share.attrs[key]}" for key, word in words.items() if key in share.attrs
    )


def wilson(count: np.ndarray, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Return both 95 % bounds of a share, if `count` of the samples are in it (Wilson, 1927)."""
    z2 = DEVIATIONS * DEVIATIONS
    share = np.asarray(count) / samples
    middle = (share + z2 / (2 * samples)) / (1 + z2 / samples)
    spread = share * (1 - share) / samples + z2 / (4 * samples * samples)
    half = DEVIATIONS * np.sqrt(spread) / (1 + z2 / samples)
    return np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)
