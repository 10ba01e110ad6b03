"""Maps: a step on a section. Every study takes a map, whatever stands behind it."""
