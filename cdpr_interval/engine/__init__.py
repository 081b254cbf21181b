"""Branch and prune that knows no robot."""
