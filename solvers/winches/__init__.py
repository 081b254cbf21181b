"""Winches in commands: where the platform is, which path it takes, and drives for one session."""
