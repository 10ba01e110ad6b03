#!/bin/sh
# Usage: sh scripts/environment.sh runtime|test
# Make .venv and install the pinned dependencies into it, or add those of the tests. Called by make.
set -eu

python=${PYTHON:-python3}

fail() {
    printf 'grazing: %s\n' "$@" >&2
    exit 1
}

check_python() {
    command -v "$python" >/dev/null 2>&1 || fail \
        "there is no '$python' here; Python 3.11 or newer is needed." \
        "Debian, Ubuntu: apt install python3 python3-venv; Fedora: dnf install python3; macOS: brew install python." \
        "If it has another name: make PYTHON=python3.12 ..."
    found=$("$python" -c 'import sys; print(".".join(str(n) for n in sys.version_info[:3]))') || fail \
        "'$python' is there but does not run." \
        "Name another one: make PYTHON=python3.12 ..."
    "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || fail \
        "'$python' is Python $found; 3.11 or newer is needed." \
        "Install one (Debian, Ubuntu: apt install python3.12 python3.12-venv; others: python.org)" \
        "and name it: make PYTHON=python3.12 ..."
    "$python" -c 'import ensurepip, venv' >/dev/null 2>&1 || fail \
        "'$python' (Python $found) cannot make environments: its module venv or ensurepip is missing." \
        "Debian, Ubuntu: apt install python${found%.*}-venv; elsewhere install the complete Python from python.org."
}

# The pip is the one that venv brought. What builds the package is installed first and then used as it is,
# because pip pins an isolated build in one way before 25.3 and in another way after.
install() {
    pip="-m pip --disable-pip-version-check install --constraint constraints.txt"
    .venv/bin/python $pip hatchling editables && .venv/bin/python $pip --no-build-isolation --editable "$1"
}

# Whether an earlier run finished here: then newer pins are installed over it, else all is made anew.
whole() {
    test -e .venv/ready && .venv/bin/python -I -c 'import pip' && test "$(cat .venv/folder)" = "$(pwd -P)"
}

case ${1:-} in
runtime)
    if ! whole 2>/dev/null; then
        check_python
        echo "grazing: making .venv"
        rm -rf .venv
        "$python" -m venv .venv
    fi
    echo "grazing: installing the packages pinned in constraints.txt (once, about 700 MB on disk)"
    rm -f .venv/ready .venv/ready-test
    install .
    pwd -P >.venv/folder
    touch .venv/ready
    ;;
test)
    echo "grazing: installing the packages of the tests (once)"
    # No stamp stands while pip works: killed half-way, the next run starts anew. A pip that only fails, without
    # a network for example, has changed nothing, so the stamp comes back and `make paper` goes on working.
    rm -f .venv/ready-test
    mv .venv/ready .venv/ready-before
    status=0
    install ".[test]" || status=$?
    mv .venv/ready-before .venv/ready
    test "$status" = 0 || exit "$status"
    touch .venv/ready-test
    ;;
*)
    fail "usage: sh scripts/environment.sh runtime|test"
    ;;
esac
