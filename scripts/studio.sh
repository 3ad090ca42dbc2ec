#!/bin/sh
# Builds the page of the server into studio/dist, which the next build of the program holds. Nothing is done where the
# result is newer than its sources. With the argument `optional` a machine without Node does without the page.
set -eu

cd "$(dirname -- "$0")/../studio"
without() {
    echo "the program is built without its page: $1" >&2
    [ "${purpose:-}" = optional ] && exit 0
    exit 3
}
purpose=${1:-}

if [ -f dist/index.html ] &&
    [ -z "$(find . \( -name node_modules -o -name dist \) -prune -o -type f -newer dist/index.html -print)" ]; then
    exit 0
fi
command -v npm >/dev/null 2>&1 || without "npm is not installed; install Node 20.19 or later, or say STUDIO=no"
node -e 'const [major, minor] = process.versions.node.split(".").map(Number);
process.exit(major > 20 || (major === 20 && minor >= 19) ? 0 : 1)' ||
    without "Node $(node --version) is too old; install Node 20.19 or later, or say STUDIO=no"
npm ci --no-audit --no-fund
npm run build
