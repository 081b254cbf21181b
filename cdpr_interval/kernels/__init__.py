"""Compiled kernels: directed rounding, intervals, second-order forms and small dense linear algebra."""

from cdpr_interval.kernels import announcement, cache

announcement.install()
cache.install()
