"""By which shock: pieces of a pulse, trains of blows, records, and the directions of a study."""

from .pulse import Pulse, make_pulse, sampled

__all__ = ["Pulse", "make_pulse", "sampled"]
