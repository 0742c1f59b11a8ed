"""The device that is shaken: quantities and units, the beam and its shape as made, the mass."""
