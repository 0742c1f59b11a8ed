"""Vibration that must or must not trip a device, held against the level that it stands."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..study import Study
from ..thresholds.requirements import MET, UNCLEAR, VIOLATED, Verdict, each_device
from .probability import RECORDS, SEED, vibration_of
from .spectrum import Spectrum


def check_vibrations(
    study: Study, vibrations: Sequence[Mapping], C: Sequence[float]
) -> list[Verdict]:
    """Find the level at which each vibration trips a study's devices as likely as it may.

    vibrations: name, psd, duration (s), snaps and probability of each; C: uN us/um
    N, N_first and N_error of a verdict are levels in g rms, with the wider half of the bounds.
    """
    return [
        verdict
        for asked, name, one in each_device(study, vibrations)
        for verdict in _verdicts(one, name, asked, C)
    ]


def _verdicts(study, name, asked, C):
    chance = 1 - asked["probability"] if asked["snaps"] else asked["probability"]
    drawn = {"records": RECORDS, "seed": SEED, "reach": chance, "duration": asked["duration"]}
    found = vibration_of(study, {"C": C}, Spectrum(asked["psd"]), drawn)
    for i, damping in enumerate(C):
        row = found.isel(C=i)
        level, low, high = (row[key].item() for key in ("level", "level_low", "level_high"))
        error = max(high - level, level - low) if np.isfinite(level) else np.nan
        verdict = UNCLEAR
        if low > found.rms or high < found.rms:
            verdict = MET if (high < found.rms) == asked["snaps"] else VIOLATED
        yield Verdict(
            *(asked["name"], name, "random", "both", found.rms),
            *(np.nan, 1e3 * asked["duration"], damping, asked["snaps"]),
            "snapped" if row.snaps > 0 else "unsnapped",
            *(level, error, level / found.rms, error / found.rms, verdict),
            *(np.nan, np.nan),
        )
