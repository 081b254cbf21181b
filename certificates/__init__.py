"""Certificates of completeness and their independent checker.

This package imports the standard library, python-flint and itself, nothing else: it shares no
code with the programs whose results it checks.
"""
