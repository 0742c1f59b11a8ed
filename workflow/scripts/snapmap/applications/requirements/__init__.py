"""Shocks that must or must not trip a device.  Imports: core alone."""
