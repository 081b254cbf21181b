"""YAML and JSON files of any kind as checked trees, every error with its line and column."""
