"""Platforms whose cables run over pulleys: the ropes, and what holds at their poses."""
