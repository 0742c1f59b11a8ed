"""The motion of single cells in full.  Imports: core alone."""
