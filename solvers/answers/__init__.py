"""What is answered: results as data, their order, text and files, and what contradicts them."""
