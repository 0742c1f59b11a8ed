"""Devices of which some values are others."""

from dataclasses import replace

from snapmap.device import ALONE


def varied(device, **values):
    """The device with other values, its own or its beam's."""
    of_beam = {key: values.pop(key) for key in [*values] if hasattr(device.beam, key)}
    return replace(device, beam=replace(device.beam, **of_beam), **values)


def alone(device, force=0.0, **values):
    """Its beam alone, shaken, or pushed by a force."""
    return varied(device, **ALONE, force=force, **values)
