#!/bin/sh
# What the Dockerfile runs: install from a checkout into a prefix, fill the kernel cache, leave both read-only.
#
#   container_build.sh CHECKOUT PREFIX [pip options]
#
# PREFIX/bin/cdpr-solve then runs as any user, without a home, from folders that cannot be written.
set -eu
checkout=$1
prefix=$2
shift 2

python3 -m venv "$prefix"
"$prefix/bin/pip" install --quiet --no-cache-dir --disable-pip-version-check "$@" "$checkout[report,plot]"
# A kernel's machine code is for this processor: an image for many kinds names a common one in NUMBA_CPU_NAME.
echo "cdpr-solve: compiling kernels, some minutes of processor time"
"$prefix/bin/cdpr-solve" warm-up --quiet
echo "cdpr-solve: kernels are compiled"
chmod -R a+rX,a-w "$prefix"
