#!/bin/sh
# What the Dockerfile does, in an empty folder instead of an image, and what its users do: a question as nobody in
# particular, without a home, with packages and kernels that cannot be written. Needs a package index, no Docker.
set -eu
checkout=$(cd "$(dirname "$0")/.." && pwd)
root=$(mktemp -d)
trap 'chmod -R u+w "$root"; rm -rf "$root"' EXIT
chmod 755 "$root"
# An image has no such folder: its kernels lie beside the packages.
unset NUMBA_CACHE_DIR

"$checkout/scripts/container_build.sh" "$checkout" "$root/cdpr"
nobody=
if [ "$(id -u)" = 0 ] && command -v setpriv >/dev/null; then
  nobody="setpriv --reuid=65534 --regid=65534 --clear-groups --inh-caps=-all"
  # Where only root may enter the folder of Python itself, another user cannot be tried.
  $nobody "$root/cdpr/bin/python" -c "" 2>/dev/null || nobody=
fi
said=$(cd / && env -i $nobody "$root/cdpr/bin/cdpr-solve" fk uc2 --lengths 7.5,8 --threads 1 2>&1)
echo "$said"
case $said in
  *"8 static poses, proved to be all"*) ;;
  *) echo "container_check.sh: not the answer" >&2; exit 1 ;;
esac
case $said in
  *compil*) echo "container_check.sh: the kernels of the image are not used" >&2; exit 1 ;;
esac
