"""Kinds of number that proofs are made with, and vectors of them: no robot, no certificate, no verdict."""
