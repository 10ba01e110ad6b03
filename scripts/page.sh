#!/bin/sh
# Usage: sh scripts/page.sh tools|types|d3
# tools: install what package.json pins for the explorer's page; types: check the page's types with it; d3: bundle the
# parts of d3 that scripts/d3.js names into the page, as one file that is shipped: whoever installs grazing needs no npm.
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
d3)
    tools
    {
        printf '/* d3-scale, d3-selection, d3-zoom and what they need, bundled by sh scripts/page.sh d3.\n\n'
        cat node_modules/d3-zoom/LICENSE node_modules/d3-ease/LICENSE
        printf '*/\n'
        node node_modules/esbuild/bin/esbuild scripts/d3.js --alias:d3-color=./scripts/d3-color.js --bundle --format=esm --minify --target=es2022 --legal-comments=none --log-level=warning
    } >"${2:-src/grazing/explorer/page/d3.mjs}"
    ;;
*)
    say "usage: sh scripts/page.sh tools|types|d3"
    exit 1
    ;;
esac
