"""Cells of the search: what they are tested for, how they are cut and split, and notes of their fates."""
