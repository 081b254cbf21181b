"""Motions: the static pose along lengths that change over time, proved piece by piece."""
