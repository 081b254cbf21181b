"""Platforms whose cables run over pulleys or stretch: cells, roots and claims."""
