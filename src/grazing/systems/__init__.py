"""Systems of one's own that hit things: a closed-form flight, surfaces with a law each, and the first contact."""
