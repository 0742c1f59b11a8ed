"""Spectra that must or must not trip a device, held against what it stands."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..shocks import make_shocks
from ..study import Study
from ..thresholds.requirements import MET, UNCLEAR, VIOLATED, Verdict, each_device
from .psd import Spectrum
from .srs import check_points
from .trips import FACTORS, ends, trips_of
from .trips import RECORDS as SHOCKS
from .vibration import RECORDS, SEED, vibration_of


def check_vibrations(
    study: Study, vibrations: Sequence[Mapping], C: Sequence[float]
) -> list[Verdict]:
    """Find the level at which each vibration trips a study's devices as likely as it may.

    vibrations: name, psd, duration (s), snaps and probability of each; C: uN us/um
    N, N_first and N_error of a verdict are levels in g rms, with the wider half of the bounds.
    """
    verdicts = []
    for asked, name, one in each_device(study, vibrations):
        chance = 1 - asked["probability"] if asked["snaps"] else asked["probability"]
        drawn = {"records": RECORDS, "seed": SEED, "reach": chance, "duration": asked["duration"]}
        found = vibration_of(one, {"C": C}, Spectrum(asked["psd"]), drawn)
        shock = "random", "both", found.rms, np.nan, 1e3 * asked["duration"]
        for i, damping in enumerate(C):
            row = found.isel(C=i)
            level, low, high = (row[key].item() for key in ("level", "level_low", "level_high"))
            error = max(high - level, level - low) if np.isfinite(level) else np.nan
            seen = bool(row.snaps > 0), low, high, level, error
            verdicts.append(_verdict(asked, name, shock, damping, *seen))
    return verdicts


def check_spectra(
    study: Study, spectra: Sequence[Mapping], C: Sequence[float], records: int = SHOCKS
) -> list[Verdict]:
    """Find the factor of each spectrum from which a record of it snaps a study's devices.

    spectra: name, srs (pairs of Hz and multiples of g), direction and snaps of each; where it must
        snap, the factor is that from which all records do; C: uN us/um
    N, N_first and N_error of a verdict are factors of the spectrum, with half the step about it.
    """
    verdicts, drawn = [], {"records": records, "seed": SEED}
    for asked, name, one in each_device(study, spectra):
        one = replace(one, shocks=make_shocks(direction=asked["direction"]))
        try:
            found = trips_of(one, {"C": C}, check_points(asked["srs"]), drawn)
        except ValueError as error:  # a spectrum that no record meets is seen only here
            raise ValueError(f"{asked['name']}: {error}") from None
        shock = "spectrum", asked["direction"], 1.0, np.nan, np.nan
        for damping, snaps in zip(C, found.snaps.values, strict=True):
            low, high = ends(snaps)[2:] if asked["snaps"] else ends(snaps)[:2]
            half = (high - low) / 2 if high < np.inf else np.nan
            given = snaps[:, FACTORS.index(1.0)] == 1
            snapped = given.all() if asked["snaps"] else given.any()
            seen = snapped, low, high, (high + low) / 2 if high < np.inf else np.nan, half
            verdicts.append(_verdict(asked, name, shock, damping, *seen))
    return verdicts


def _verdict(asked, name, shock, C, snapped, low, high, level, error):
    """shock: of a verdict, shape to duration; low, high: between which the level lies."""
    N, must = shock[2], asked["snaps"]
    verdict = UNCLEAR
    if low > N or high < N:
        verdict = MET if (high < N) == must else VIOLATED
    seen = "snapped" if snapped else "unsnapped", level, error, level / N, error / N, verdict
    return Verdict(asked["name"], name, *shock, C, must, *seen, np.nan, np.nan)
