"""The value of a device that gives a threshold or meets requirements.  Imports: tolerances."""
