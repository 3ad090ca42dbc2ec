#!/bin/sh
# Prints the path of a Python of the versions $1 to $2 (3.11 3.14; `later` has no end), one with the venv module where
# $3 is `venv`. PYTHON is the only candidate where it is set. Exit code 1: there is none, and standard error says what
# is wanted.
set -eu

lowest=$1 highest=$2 venv=${3:-}
case $highest in
"$lowest") range="Python $lowest" ;;
later) range="Python $lowest or later" highest=3.99 ;;
*) range="Python $lowest to $highest" ;;
esac

if [ -n "${PYTHON:-}" ]; then
    set -- "$PYTHON"
    advice="$range, which PYTHON=$PYTHON is not"
else
    # Python 3.11 comes first: every judge has packages for it.
    set -- python3.11 python3.12 python3.13 python3.14 python3 python python3.10 python3.9
    advice="$range; install it or set PYTHON to it"
fi

for candidate in "$@"; do
    command -v "$candidate" >/dev/null 2>&1 || continue
    version=$("$candidate" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null) || continue
    case $version in 3.*) ;; *) continue ;; esac
    if [ "${version#3.}" -lt "${lowest#3.}" ] || [ "${version#3.}" -gt "${highest#3.}" ]; then
        continue
    fi
    if [ -n "$venv" ] && ! "$candidate" -c 'import ensurepip, venv' 2>/dev/null; then
        advice="the venv module of $candidate (Debian: apt install python$version-venv)"
        continue
    fi
    command -v "$candidate"
    exit 0
done
echo "$advice" >&2
exit 1
