"""Platforms with six degrees of freedom: every static pose by search and proof, and one that is tracked."""
