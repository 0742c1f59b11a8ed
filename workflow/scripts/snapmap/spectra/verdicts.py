"""Spectra that must or must not trip a device, held against what it stands."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..pulse import shocks_from
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
    for required, name, own in each_device(study, vibrations):
        chance, T = required["probability"], required["duration"]
        reach = 1 - chance if required["snaps"] else chance
        drawn = {"records": RECORDS, "seed": SEED, "reach": reach, "duration": T}
        shaken = vibration_of(own, {"C": C}, Spectrum(required["psd"]), drawn)
        shock = "random", "both", shaken.rms, np.nan, 1e3 * T
        keys = "snaps", "level_low", "level_high", "level"
        columns = (shaken[key].values.tolist() for key in keys)
        for damping, snaps, low, high, level in zip(C, *columns, strict=True):
            error = max(high - level, level - low) if np.isfinite(level) else np.nan
            seen = snaps > 0, low, high, level, error
            verdicts.append(_verdict(required, name, shock, damping, *seen))
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
    for required, name, own in each_device(study, spectra):
        must, direction = required["snaps"], required["direction"]
        own = replace(own, shocks=shocks_from(direction=direction))
        try:
            tested = trips_of(own, {"C": C}, check_points(required["srs"]), drawn)
        except ValueError as error:  # a spectrum that no record meets is seen only here
            raise ValueError(f"{required['name']}: {error}") from None
        shock = "spectrum", direction, 1.0, np.nan, np.nan
        for damping, snaps in zip(C, tested.snaps.values, strict=True):
            low, high = ends(snaps)[2:] if must else ends(snaps)[:2]
            middle, half = (high + low) / 2, (high - low) / 2
            given = snaps[:, FACTORS.index(1.0)] == 1
            level = (middle, half) if high < np.inf else (np.nan, np.nan)
            seen = given.all() if must else given.any(), low, high, *level
            verdicts.append(_verdict(required, name, shock, damping, *seen))
    return verdicts


def _verdict(required, name, shock, C, snapped, low, high, level, error):
    """shock: of a verdict, shape to duration; low, high: between which the level lies."""
    N, must = shock[2], required["snaps"]
    verdict = UNCLEAR
    if low > N or high < N:
        verdict = MET if (high < N) == must else VIOLATED
    seen = "snapped" if snapped else "unsnapped", level, error, level / N, error / N, verdict
    return Verdict(required["name"], name, *shock, C, must, *seen, np.nan, np.nan)
