"""Platforms on real cables: paths over swivelling pulleys, cables that stretch."""
