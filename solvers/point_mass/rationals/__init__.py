"""What is decided of a point mass in exact rationals, after a float guess."""
