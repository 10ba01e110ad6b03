"""Orbits: what a map repeats, named by the word of the letters it visits."""
