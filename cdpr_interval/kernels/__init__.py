"""Compiled kernels: directed rounding, intervals, affine forms and small dense linear algebra."""
