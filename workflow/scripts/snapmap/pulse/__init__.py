"""The shock: shapes of pulses, trains of blows, recorded pulses, and the directions of a study."""

from .pulse import Pulse, make_pulse, sampled

__all__ = ["Pulse", "make_pulse", "sampled"]
