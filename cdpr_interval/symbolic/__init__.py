"""Symbolic layer: exact polynomial systems of point masses, their eliminants, and certified roots."""
