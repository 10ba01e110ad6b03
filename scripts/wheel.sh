#!/bin/sh
# Usage: sh scripts/wheel.sh [FAMILY ...]
# Build a wheel of the last commit into dist/ that holds the kernels compiled for families of processors, all that this machine can run if
# none is named. It is for this system, this Python and the numba installed here; elsewhere kernels compile at first use.
set -eu

python=$(pwd -P)/.venv/bin/python
here=$(pwd -P)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
# what others may write to is not prepared
git -c tar.umask=0022 archive HEAD | tar -xf - -C "$scratch"
cd "$scratch"
export PYTHONPATH="$scratch/src"
for family in ${*:-x86-64-v2 x86-64-v3 x86-64-v4}; do
    "$python" -m grazing.prepare --family "$family" || test $# = 0
done
"$python" -m hatchling build --target wheel --directory "$here/dist"
