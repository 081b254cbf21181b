"""What runs a check: which cells, in which order, by how many processes, until when. It proves nothing."""
