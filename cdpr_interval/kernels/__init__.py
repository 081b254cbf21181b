"""Compiled kernels: directed rounding, intervals, second-order forms and small dense linear algebra."""
