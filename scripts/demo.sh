#!/usr/bin/env bash
# The robots of the papers through the command line, as a user would type it.
# The first run compiles the kernels, two minutes of processor time; later runs load them.
set -euo pipefail

say() {
  echo
  printf '# %s\n' "$@"
}

solve() {
  printf '$ cdpr-solve %s\n' "$*"
  local code=0
  cdpr-solve "$@" || code=$?
  case $code in
    0) ;;
    3) echo "(exit 3: every pose listed is proved, but a cable's state or a region above is left undecided)" ;;
    4) echo "(exit 4: proved that there is no such pose)" ;;
    *) exit "$code" ;;
  esac
}

say "Merlet 2012, section III: four inextensible cables on one point. The first three lengths put it at" \
  "(1, 1.5, -2) m; the fourth cable is a little too short for that. Which cables are taut now?"
solve fk merlet_4_1 \
  --lengths 2.6925824035672520156,3.9051248379533270634,3.3541019662496845446,4.385

say "Four equal cables: the pose is proved, but four cables share a load that three can carry."
solve fk merlet_4_1 --lengths 3,3,3,3

say "Merlet 2012, section IV: elastic cables (unstretched lengths), k = 100 N/cm, then k = 1000 N/cm."
solve fk merlet_4_1_k100 --lengths 2.955855,2.955855,4.10288,4.10288
solve fk merlet_4_1_k1000 --lengths 2.99558,2.99558,4.121083,4.121083

say "Lengths known to 1 cm: one box around the poses of all of them."
solve fk merlet_4_1 --lengths 2.69+-0.01,3.9+-0.01,3.35+-0.01,4.5

say "Platforms that hang on two, three and four cables: every pose, for every subset that can be taut." \
  "Exactly one pose of each is stable; the others balance, but would not be seen."
solve fk uc2 --lengths 7.5,8
solve fk uc3 --lengths 7.5,8,7
solve fk uc4 --lengths 7.5,8,7,9

say "CoGiRo, eight cables: lengths and tensions at a pose (plain floats, not certified)."
solve ik cogiro --pose 0,0,1

say "Four of its cables carry the load, the others are 5 % longer than they need to be: a static pose near" \
  "(0, 0, 2) m, turned by 96 degrees and therefore asked for, and every pose that these lengths allow with the same" \
  "four cables taut."
settled=$(solve ik cogiro --pose 0,0,2 --taut c1,c3,c5,c7 --settle --settle-within 1.5)
printf '%s\n' "$settled"
solve fk cogiro --taut c1,c3,c5,c7 --lengths "$(sed -n 's/^--lengths //p' <<<"$settled")"

say "A thousand lengths and stiffnesses around the nominal ones, every answer proved and written down, and a report."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp "$(dirname "${BASH_SOURCE[0]}")/demo_batch.yaml" "$folder/jobs.yaml"
(cd "$folder" && solve batch jobs.yaml --out run && solve report run --out report.html && ls run report.html)
