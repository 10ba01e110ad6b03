"""Comparisons: what the reductions of a model keep of it, rung by rung."""
