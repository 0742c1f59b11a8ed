"""Discretisations of the clamped beam, one file each; every one returns a `Basis`."""
