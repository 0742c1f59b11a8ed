"""Shock response spectra that must or must not trip a device, held against what it stands."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..pulse import shocks_from
from ..study import Study
from ..thresholds.requirements import MET, UNCLEAR, VIOLATED, Verdict, each_device
from .spectrum import check_points
from .trips import FACTORS, RECORDS, SEED, ends, trips_of


def check_spectra(
    study: Study, spectra: Sequence[Mapping], C: Sequence[float], records: int = RECORDS
) -> list[Verdict]:
    """Find the factor of each spectrum from which a record of it snaps a study's devices.

    spectra: name, srs (pairs of Hz and multiples of g), direction and snaps of each; where it must
        snap, the factor is that from which all records do; C: uN us/um
    N, N_first and N_error of a verdict are factors of the spectrum, with half the step about it.
    """
    return [
        verdict
        for asked, name, one in each_device(study, spectra)
        for verdict in _verdicts(
            replace(one, shocks=shocks_from(direction=asked["direction"])), name, asked, C, records
        )
    ]


def _verdicts(study, name, asked, C, records):
    drawn = {"records": records, "seed": SEED}
    try:
        found = trips_of(study, {"C": C}, check_points(asked["srs"]), drawn)
    except ValueError as error:  # a spectrum that no record meets is seen only here
        raise ValueError(f"{asked['name']}: {error}") from None
    for damping, snaps in zip(C, found.snaps.values, strict=True):
        low, high = ends(snaps)[2:] if asked["snaps"] else ends(snaps)[:2]
        first, error = ((high + low) / 2, (high - low) / 2) if high < np.inf else (np.nan, np.nan)
        verdict = UNCLEAR
        if low > 1 or high < 1:
            verdict = MET if (high < 1) == asked["snaps"] else VIOLATED
        given = snaps[:, FACTORS.index(1.0)] == 1
        snapped = given.all() if asked["snaps"] else given.any()
        yield Verdict(
            *(asked["name"], name, "spectrum", asked["direction"], 1.0),
            *(np.nan, np.nan, damping, asked["snaps"]),
            "snapped" if snapped else "unsnapped",
            *(first, error, first, error, verdict),
            *(np.nan, np.nan),
        )
