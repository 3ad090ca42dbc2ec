#!/bin/sh
# Names what is missing before anything is started; prints the Python to use.
# With `demo` as its argument it asks for no venv.
set -eu

missing() {
    echo "missing prerequisite: $1" >&2
    exit 3
}

if ! command -v "${CARGO:-cargo}" >/dev/null 2>&1; then
    # Where rustup puts it when the shell does not know yet.
    [ -x "$HOME/.cargo/bin/cargo" ] || missing "a Rust toolchain (cargo); install rustup and open a new shell"
    missing "cargo is installed but not on the PATH; run: . \"\$HOME/.cargo/env\""
fi
command -v "${CC:-cc}" >/dev/null 2>&1 || missing "a C compiler named ${CC:-cc} (Debian: apt install build-essential), or set CC to yours"

python=
for candidate in "${PYTHON:-}" python3.11 python3; do
    [ -n "$candidate" ] && command -v "$candidate" >/dev/null 2>&1 || continue
    if "$candidate" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null; then
        python=$candidate
        break
    fi
done
[ -n "$python" ] || missing "Python 3.11 (one of the judges has no packages for later versions); install it or set PYTHON to it"
if [ "${1:-}" != demo ]; then
    for tool in fmt clippy; do
        "${CARGO:-cargo}" $tool --version >/dev/null 2>&1 ||
            missing "cargo $tool; run: rustup component add rustfmt clippy"
    done
    "$python" -c 'import ensurepip, venv' 2>/dev/null ||
        missing "the venv module of $python (Debian: apt install python3.11-venv)"
    # Whether it also works is for the tests to find out, which then fail.
    [ "${TABLETOPGEN_GPU_TESTS:-require}" != require ] || "$python" -c '
import ctypes, sys
def loads(name):
    try:
        return bool(ctypes.CDLL(name))
    except OSError:
        return False
sys.exit(sys.platform == "linux" and not (loads("libEGL.so.1") or loads("libvulkan.so.1")))
' || missing "an OpenGL or Vulkan driver for the tests of the GPU kernels, a software one will do (Debian: apt install \
libegl1 libgl1-mesa-dri, or mesa-vulkan-drivers); TABLETOPGEN_GPU_TESTS=optional does without"
fi
command -v "$python"
