"""A ball in the plane among things that it hits: the pinball table."""
