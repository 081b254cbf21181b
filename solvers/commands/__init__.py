"""The commands of ``cdpr-solve``, one a module; importing one imports nothing heavy."""
