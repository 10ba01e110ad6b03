"""Kernels: the only folder that names numba.

A kernel is a plain scalar Python function. It runs as it stands, and :func:`compiled` turns it, with everything
it calls, into machine code in one of two arithmetics. The other modules of this folder are the few primitives
that plain Python has no fast form for, and the loop that drives a step over many lanes.
"""
