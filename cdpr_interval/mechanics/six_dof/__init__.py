"""A platform with six degrees of freedom over a cell: geometry, balance, frames and families."""
