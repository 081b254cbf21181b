"""Mechanics of loaded bodies on cables, whatever the question: rotations, wrenches, stability."""
