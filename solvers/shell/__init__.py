"""What a shell and its user see of commands beside what they do: completion, examples."""
