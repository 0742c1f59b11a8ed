"""Usual values of a device, and warnings of values beyond them, as after a slip of a unit."""

import numpy as np

USUAL = {
    "youngs_modulus": (1e3, 1.3e6),
    "density": (1e-4, 0.025),
    "damping": (0.0, 1e3),
    "residual_stress": (-3e3, 3e3),
    "clamp_axial": (1.0, 1e9),
    "mass": (1e-3, 1e6),
    "spring": (1e-4, 1e6),
    "contact": (1e-3, 1e8),
    **dict.fromkeys(("gap", "stop_toward", "stop_away"), (1e-3, 1e3)),
    **dict.fromkeys(("temperature", "reference_temperature"), (-273.0, 1000.0)),
    "modulus_slope": (-0.01, 0.01),
    "expansion_mismatch": (-1e-3, 1e-3),
    "damper_exponent": (-10.0, 10.0),
    **dict.fromkeys(("strength", "strength_threshold"), (1.0, 1e5)),
    "gravity": (1e-7, 1e-3),
}
"""Ranges, in internal units, beyond which a value is probably a slip."""


def require(holds: np.ndarray, complaint: str, *values: np.ndarray) -> None:
    """Raise ValueError if `holds` is false anywhere; the first values there fill the complaint."""
    wrong = np.flatnonzero(~np.atleast_1d(holds))
    if wrong.size:
        first = [np.broadcast_to(value, np.size(holds))[wrong[0]] for value in values]
        raise ValueError(complaint.format(*first))
