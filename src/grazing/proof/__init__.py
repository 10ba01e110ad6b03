"""Proofs: certificates in ball arithmetic, and checkers that verify them without the finder."""
