"""An oracle for forward kinematics that shares nothing with the solvers.

Static poses are found by multi-start Newton over all taut subsets in floats, refined to 50 digits with
mpmath, and classified by Hessians. ``compare`` reads the ``cdpr-result/1`` document of an answer and says
what contradicts it. Only numpy and mpmath are used here; what calls the solvers lives in the tests
and in ``scripts/fuzz_oracle.py``.
"""
