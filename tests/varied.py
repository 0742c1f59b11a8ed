"""Devices of which some values are others."""

from dataclasses import replace

import numpy as np

from snapmap.device.device import ALONE
from snapmap.solver.steps import fixed


def varied(device, **values):
    """The device with other values, its own or its beam's."""
    of_beam = {key: values.pop(key) for key in [*values] if hasattr(device.beam, key)}
    return replace(device, beam=replace(device.beam, **of_beam), **values)


def alone(device, force=0.0, **values):
    """Its beam alone, shaken, or pushed by a force."""
    return varied(device, **ALONE, force=force, **values)


def share_of_limit(share):
    """The rule of one step for all questions: a share of 2/omega_max of linear bending."""

    def rule(device, modal):
        of_beam = 2 / np.sqrt(modal.stiffness[..., -1])
        limit = np.where(device.is_alone, of_beam, np.minimum(of_beam, 2 / device.mass_frequency))
        return fixed(np.atleast_1d(share * limit))

    return rule


def in_steps(model, share):
    """The model in such steps."""
    return replace(model, steps=share_of_limit(share)(model.device, model.modal))
