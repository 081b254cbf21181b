"""Where a point mass is, in plain floating point: guesses that are proved elsewhere."""
