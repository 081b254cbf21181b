"""``python -m solvers`` is ``cdpr-solve``."""

from solvers.cli import main

if __name__ == "__main__":
    main()
