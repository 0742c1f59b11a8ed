"""Random vibration and shock response spectra.  Imports: requirements."""
