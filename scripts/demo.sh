#!/usr/bin/env bash
# The examples of the papers through the command line, as a user would type them.
set -euo pipefail

solve() {
  echo
  echo "\$ cdpr-solve $*"
  cdpr-solve "$@"
}

# Merlet 2012, section III: four cables on one point; lengths of three of them put the load at
# (1, 1.5, -2) m, the fourth is 438.5 cm.
solve fk merlet_4_1 \
  --lengths 2.692582403567252015625355,3.905124837953327119706486,3.354101966249684454461377,4.385

# Platforms that hang on two, three and four cables: every pose, for every subset that can be taut.
solve fk uc2 --lengths 7.5,8
solve fk uc3 --lengths 7.5,8,7
solve fk uc4 --lengths 7.5,8,7,9
