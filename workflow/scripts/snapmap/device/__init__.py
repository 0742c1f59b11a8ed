"""What is shaken: quantities with their units, a beam, its shape as made, and mass and spring."""

from .device import Beam, Device, batch

__all__ = ["Beam", "Device", "batch"]
