"""Exact numbers and proved bounds outside compiled code: irrationals, balls, doubles around rationals."""
