"""The level of the next shot: up and down, after Langlie, or D-optimal after Neyer."""

import numpy as np

from .probit import best, has_estimate, information

SHRINK = 0.8
"""Of the guessed spread with each shot that seeks an overlap (Neyer, 1994)."""
STEPS = np.arange(-4000, 4001) / 1000
"""Where a D-optimal level is sought, standard deviations from the mean."""


def next_level(
    N: np.ndarray, tripped: np.ndarray, method: str, low: float, high: float, sigma: float
) -> tuple[float, str]:
    """The next level, N, and what it is for.

    N, tripped: of the shots so far, (shots,); method: a key of METHODS
    low, high: between which the mean is guessed; sigma: the guessed standard deviation
    """
    if not N.size:
        return (low + high) / 2, "first, in the middle"
    level, why = METHODS[method](N, tripped, low, high, sigma)
    return (float(level), why) if level > 0 else (float(N.min() / 2), "half of the lowest")


def _up_and_down(N, tripped, low, high, sigma):
    return (N[-1] - sigma, "one step down") if tripped[-1] else (N[-1] + sigma, "one step up")


def _langlie(N, tripped, low, high, sigma):
    balance = np.cumsum(np.where(tripped[::-1], 1, -1))
    even = np.flatnonzero(balance == 0)
    if even.size:
        back = even[0] + 1
        return (N[-1] + N[-back]) / 2, f"as many of the last {back} tripped as did not"
    end, word = (low, "lower") if tripped[-1] else (high, "upper")
    return (N[-1] + end) / 2, f"towards the {word} end"


def _neyer(N, tripped, low, high, sigma):
    for shots in range(2, N.size):
        if _phase(N[:shots], tripped[:shots], sigma) == "overlap":
            sigma *= SHRINK
    phase = _phase(N, tripped, sigma)
    if phase == "up":
        level = max((high + N.max()) / 2, N.max() + 2 * sigma, 2 * N.max() - N.min())
        return level, "find: none has tripped"
    if phase == "down":
        level = min((low + N.min()) / 2, N.min() - 2 * sigma, 2 * N.min() - N.max())
        return level, "find: all have tripped"
    middle, width = (N[tripped].min() + N[~tripped].max()) / 2, np.ptp(N)
    if phase == "gap":
        return middle, "find: halfway between the kinds"
    if phase == "overlap":
        return _d_optimal(N, middle, min(sigma, width)), "overlap: about the guessed mean"
    if not has_estimate(N, tripped):
        # ASSUME: where those that tripped are no higher than the others, the spread is all of it.
        return _d_optimal(N, middle, width), "estimate: the kinds lie upside down"
    mean, spread = best(N, tripped)
    clipped = np.clip(mean, N.min(), N.max()), min(spread, width)
    return _d_optimal(N, *clipped), "estimate: D-optimal about the fit"


def _phase(N, tripped, sigma):
    if tripped.all() or not tripped.any():
        return "down" if tripped.all() else "up"
    gap = np.round(N[tripped].min() - N[~tripped].max(), 12)
    if gap > sigma:
        return "gap"
    return "overlap" if gap >= 0 else "estimate"


def _d_optimal(N, mean, sigma):
    """The level that makes the determinant of the information of all shots largest."""
    so_far = information(N, mean, sigma).sum(axis=-1)
    total = so_far[..., np.newaxis] + information(mean + STEPS * sigma, mean, sigma)
    determinant = total[0, 0] * total[1, 1] - total[0, 1] ** 2
    return mean + STEPS[np.argmax(determinant)] * sigma


METHODS = {"neyer": _neyer, "langlie": _langlie, "up-and-down": _up_and_down}


def dixon_mood(N: np.ndarray, tripped: np.ndarray) -> tuple[float, float] | None:
    """Mean and standard deviation of shots up and down in equal steps (Dixon & Mood, 1948).

    The standard deviation is NaN where their formula does not hold: M at most 0.3. None where
    levels are not equally far apart.
    """
    apart = np.diff(np.unique(np.round(N, 9)))
    step = apart.min(initial=np.inf)
    if not (apart.size and np.allclose(apart, step)):
        return None
    rarer = tripped if 2 * tripped.sum() <= tripped.size else ~tripped
    i = np.round((N[rarer] - N[rarer].min()) / step)
    half = -0.5 if rarer is tripped else 0.5
    mean = N[rarer].min() + step * (i.mean() + half)
    M = i.var()
    return float(mean), float(1.62 * step * (M + 0.029)) if M > 0.3 else np.nan
