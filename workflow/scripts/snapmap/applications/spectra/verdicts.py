"""Verdicts on required vibration and required shock response spectra."""

from collections.abc import Iterator, Sequence

import numpy as np

from ...pulse.shocks import make_shocks
from ...study.study import ARRIVES, Study
from ..requirements.check import each_device
from ..requirements.corners import MET, UNCLEAR, VIOLATED, Verdict
from .psd import Spectrum
from .required import RequiredSpectrum, RequiredVibration
from .srs import check_points
from .trips import FACTORS, ends, trips_of
from .trips import RECORDS as SHOCKS
from .vibration import RECORDS, SEED, vibration_of


def check_vibration(
    study: Study, required: RequiredVibration, C: Sequence[float], temperatures: Sequence[float]
) -> Iterator[Verdict]:
    """Find the level of a vibration at which a trip is as probable as it allows.

    C: uN us/um; temperatures: degC; empty for those of the devices
    N, N_first, N_error of a verdict are levels in g rms; N_error is the wider half of the bounds.
    """
    for name, shaken in each_device(required.shaken(study), temperatures):
        chance, T = required.probability, required.duration
        reach = 1 - chance if required.snaps else chance
        drawn = {"records": RECORDS, "seed": SEED, "reach": reach, "duration": T}
        rates = vibration_of(shaken, {"C": C}, Spectrum(required.psd), drawn)
        place = {"device": name, "temperature": shaken.device.temperature, "shape": "random"}
        place |= {"direction": "both", "N": rates.rms.item(), "duration": 1e3 * T}
        keys = "snaps", "level_low", "level_high", "level"
        columns = (rates[key].values.tolist() for key in keys)
        for damping, snaps, low, high, level in zip(C, *columns, strict=True):
            error = max(high - level, level - low) if np.isfinite(level) else np.nan
            bounds = low, high, level, error
            yield _verdict(required, place | {"C": damping}, snaps > 0, bounds)


def check_spectrum(
    study: Study,
    required: RequiredSpectrum,
    C: Sequence[float],
    temperatures: Sequence[float],
    records: int = SHOCKS,
) -> Iterator[Verdict]:
    """Find the factor of a spectrum from which a record snaps a study's devices.

    If it must snap, all records snap it. C: uN us/um; temperatures: degC; empty for its own
    N, N_first, N_error of a verdict are factors of the spectrum; N_error is half a step of them.
    """
    drawn = {"records": records, "seed": SEED}
    for name, shaken in each_device(required.shaken(study), temperatures):
        for shocks in make_shocks(direction=required.direction).each():
            yield from _of_spectrum(shaken.under(shocks), required, name, C, drawn)


def _of_spectrum(study, required, name, C, drawn):
    """Verdicts of one spectrum on one device in one direction, a row for each C."""
    must = required.snaps
    try:
        tested = trips_of(study, {"C": C}, check_points(required.srs), drawn)
    except ValueError as error:  # a spectrum that no record meets is seen only here
        raise ValueError(f"{required.name}: {error}") from None
    place = {"device": name, "temperature": study.device.temperature, "shape": "spectrum"}
    place |= {"direction": study.shocks.direction, "N": 1.0, "duration": np.nan}
    for damping, snaps in zip(C, tested.snaps.values, strict=True):
        low, high = ends(snaps)[2:] if must else ends(snaps)[:2]
        snapped = (np.all if must else np.any)(snaps[:, FACTORS.index(1.0)] == 1)
        estimate = ((high + low) / 2, (high - low) / 2) if high < np.inf else (np.nan, np.nan)
        bounds = low, high, *estimate
        yield _verdict(required, place | {"C": damping}, snapped, bounds)


def _verdict(required, place, snapped, bounds):
    """Make a verdict.

    place: its fields of shock and corner; bounds: ends of its level, the level, and its error
    """
    low, high, level, error = bounds
    # ASSUME: a beam need only arrive, as vibration has no end after which it could stay.
    N, must, verdict = place["N"], bool(required.snaps), UNCLEAR
    if low > N or high < N:
        verdict = MET if (high < N) == must else VIOLATED
    return Verdict(
        **place,
        requirement=required.name,
        f0=np.nan,
        must_snap=must and ARRIVES,
        outcome="snapped" if snapped else "unsnapped",
        N_first=level,
        N_error=error,
        margin=level / N,
        margin_error=error / N,
        verdict=verdict,
    )
