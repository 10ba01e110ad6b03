#!/bin/sh
# Usage: sh scripts/page.sh tools|types
# tools: install what package.json pins for checking the explorer's page; types: check the page's types with it.
# Only who changes the page needs node; where it is not, this says what is left out, and that is no failure.
set -eu

say() {
    printf 'grazing: %s\n' "$1" >&2
}

# Whether what the lock file says is there; else install it. What is missing is said by name.
tools() {
    if ! command -v node >/dev/null 2>&1 || ! command -v npm >/dev/null 2>&1; then
        say "no node and npm here (Debian: apt install nodejs npm)"
        return 1
    fi
    if ! cmp -s package-lock.json node_modules/.grazing-lock; then
        if ! npm ci --ignore-scripts --no-audit --no-fund --loglevel=error >&2; then
            say "npm could not install what package.json asks for (without a network it cannot)"
            return 1
        fi
        cp package-lock.json node_modules/.grazing-lock
    fi
}

case ${1:-} in
tools)
    tools || say "the page is not checked by axe"
    ;;
types)
    if tools; then
        node node_modules/typescript/bin/tsc --project tsconfig.json
    else
        say "the types of the page are not checked by tsc"
    fi
    ;;
*)
    say "usage: sh scripts/page.sh tools|types"
    exit 1
    ;;
esac
