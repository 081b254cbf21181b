"""What follows from a pose that is given: lengths and tensions, and a static pose near it."""
