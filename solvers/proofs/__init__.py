"""Certificates: what is written for the independent checker, and how it is asked."""
