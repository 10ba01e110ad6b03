"""Signals of a motion, as an instrument would record them: samples, spectra, sound."""
