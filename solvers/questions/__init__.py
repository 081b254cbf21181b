"""What is asked: lengths, loads, poses and subsets as users give them, made exact and checked."""
