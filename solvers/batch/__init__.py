"""Many problems at once: a job file, a ledger that survives a kill, workers here or on a cluster, tables."""
