"""Shocks known by their response spectrum."""
