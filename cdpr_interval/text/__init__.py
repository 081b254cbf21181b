"""Numbers and data as text that people type and read, exactly: YAML scalars, numbers of any kind, YAML."""
