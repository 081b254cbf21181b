"""The file format of robots: what a file may say, and how it becomes frozen data."""
