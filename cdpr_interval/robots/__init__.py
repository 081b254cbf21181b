"""Robots: frozen data (`model`), the file reader (`reader`) and the robots that ship (`library/`)."""
