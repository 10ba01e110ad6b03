#!/bin/sh
# Usage: sh scripts/numba.sh oldest|newest
# Run the tests of kernels with the oldest numba that pyproject.toml allows, or the newest that was there when its pins
# were written: constraints-numba-oldest.txt, constraints-numba-newest.txt. Everything else is that of .venv.
# An environment that cannot be had, without a network for example, is said by name, and that is no failure; nor is one
# that .venv is already: `make test` runs these tests there.
set -eu

which=${1:-}
pins=constraints-numba-$which.txt
test -f "$pins" || { echo "usage: sh scripts/numba.sh oldest|newest" >&2; exit 1; }
own=.venv-numba-$which

same='import importlib.metadata as there, sys
sys.exit(any(there.version(name) != pin for name, pin in (line.split("==") for line in sys.stdin.read().split())))'
if .venv/bin/python -I -c "$same" <"$pins"; then
    echo "grazing: $(tr '\n' ' ' <"$pins")are those of .venv, which \`make test\` tests"
    exit 0
fi

if ! cmp -s "$pins" "$own/pins" 2>/dev/null; then
    rm -rf "$own"
    .venv/bin/python -m venv "$own"
    # --no-deps: the pins are all that is to be different
    if ! "$own/bin/python" -m pip --disable-pip-version-check --quiet install --no-deps --requirement "$pins"; then
        rm -rf "$own"
        echo "grazing: no environment with the $which numba ($(tr '\n' ' ' <"$pins")could not be installed): not tested" >&2
        exit 0
    fi
    folder='import sysconfig; print(sysconfig.get_path("purelib"))'
    (cd .venv/bin && ./python -c "$folder") >"$("$own/bin/python" -c "$folder")/everything_else.pth"
    cp "$pins" "$own/pins"
fi
echo "grazing: kernels with $(tr '\n' ' ' <"$pins")"
shift
GRAZING_CACHE=$(pwd)/$own/kernels "$own/bin/python" -m pytest -q -n 2 --dist worksteal -p no:cacheprovider tests/kernel "$@"
