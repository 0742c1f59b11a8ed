"""How well levels by each method tell the thresholds, and what intervals cover: docs/planning.md.

PYTHONPATH=workflow/scripts ./run python -m studies.planning [--small]
"""

import numpy as np

from snapmap.calibration.planning import best, estimate, has_estimate, next_level
from snapmap.io.markdown import table

from .few import few

METHODS = "neyer", "up-and-down"
SHOTS, CAMPAIGNS, SEED = (15, 30, 60), 200, 1
CONFIDENCE = 0.95
FIRE = 3.090232306167813
"""Standard deviations from the mean to the all-fire level."""
HEAD = ["method", "shots", "estimate", "error of mean", "of sigma", "sigma found", "mean covered"]
HEAD += ["sigma", "all-fire", "all-fire open"]
GUESSES = ((0.0, 1.0), (2.0, 1.0), (0.0, 2.0), (0.0, 0.5))
"""Mean and standard deviation that the model has, where true ones are 0 and 1."""


def main():
    rows = [[name, str(n), *judge(name, n, (0.0, 1.0))] for name in METHODS for n in few(SHOTS)]
    print(table(HEAD, rows))
    head = ["method", "model's mean", "its sigma", *HEAD[2:]]
    rows = [
        [name, *map("{:g}".format, guess), *judge(name, SHOTS[1], guess)]
        for name in METHODS
        for guess in few(GUESSES)
    ]
    print(table(head, rows))


def judge(method, shots, guess):
    """Campaigns of shots whose thresholds have mean 20 and standard deviation 1."""
    found, covered, known = [], [], 0
    for campaign in range(few(CAMPAIGNS, 4)):
        N, tripped = campaign_of(method, shots, guess, np.random.default_rng([SEED, campaign]))
        if has_estimate(N, tripped):
            known += 1
            found.append(best(N, tripped))
            told = estimate(N, tripped, CONFIDENCE)
            truth = 20.0, 1.0, 20.0 + FIRE
            parts = told.mean, told.sigma, told.all_fire
            inside = [one.low <= true <= one.high for one, true in zip(parts, truth, strict=True)]
            covered.append([*inside, np.isinf(told.all_fire.high)])
    if not known:
        return ["0 %"]
    mean, sigma = np.array(found).T
    shares = [f"{100 * share:.0f} %" for share in np.mean(covered, axis=0)]
    rms = [f"{np.sqrt(np.mean(part**2)):.2f}" for part in (mean - 20, sigma - 1)]
    share = f"{100 * known / few(CAMPAIGNS, 4):.0f} %"
    return [share, *rms, f"{np.median(sigma):.2f}", *shares]


def campaign_of(method, shots, guess, draw):
    """Levels and answers of one campaign."""
    mean, sigma = 20 + guess[0], guess[1]
    N, tripped = np.empty(0), np.empty(0, bool)
    for _ in range(shots):
        level, _ = next_level(N, tripped, method, mean - 4 * sigma, mean + 4 * sigma, sigma)
        N, tripped = np.append(N, level), np.append(tripped, level >= draw.normal(20.0, 1.0))
    return N, tripped


if __name__ == "__main__":
    main()
