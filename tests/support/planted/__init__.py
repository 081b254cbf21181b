"""Random robots with static poses known beforehand, and the verdict whether a solver lost one."""
