"""The search of one taut subset: cells, what they are put to, and the roots or tubes that settle them."""
