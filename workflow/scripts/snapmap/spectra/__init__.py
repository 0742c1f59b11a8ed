"""Shocks known by a spectrum: random vibration, and shock response spectra."""
