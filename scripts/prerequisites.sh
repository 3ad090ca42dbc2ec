#!/bin/sh
# Names what is missing before anything is started; prints the Python to use. Its argument says for what:
# build, wheel, demo, fuzz, train, bars, or test, which is the default.
# Only the demo does without a Python; then this prints nothing.
set -eu

purpose=${1:-test}
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)

missing() {
    echo "missing prerequisite: $1" >&2
    exit 3
}

if ! command -v "${CARGO:-cargo}" >/dev/null 2>&1; then
    # Where rustup puts it when the shell does not know yet.
    [ -x "${HOME:-}/.cargo/bin/cargo" ] || missing "a Rust toolchain (cargo); install rustup and open a new shell"
    missing "cargo is installed but not on the PATH; run: . \"\$HOME/.cargo/env\""
fi
command -v "${CC:-cc}" >/dev/null 2>&1 || missing "a C compiler named ${CC:-cc} (Debian: apt install build-essential), or set CC to yours"
# The video encoder is C++.
command -v "${CXX:-c++}" >/dev/null 2>&1 || missing "a C++ compiler named ${CXX:-c++} (Debian: apt install build-essential), or set CXX to yours"

case $purpose in
build) exit 0 ;;
demo | fuzz) set -- 3.9 later ;;
train) set -- 3.11 3.13 venv ;;
# PyBullet and Blender have no packages for later versions.
bars) set -- 3.11 3.11 venv ;;
test | wheel) set -- 3.11 3.14 venv ;;
*)
    echo "usage: $0 [build|wheel|demo|fuzz|train|bars|test]" >&2
    exit 2
    ;;
esac
if ! python=$("$here/python.sh" "$@" 2>&1); then
    [ "$purpose" != demo ] || [ -n "${PYTHON:-}" ] || exit 0
    missing "$python"
fi

# Those of the libraries that the system lacks.
lacking() {
    "$python" -c '
import ctypes, sys
for name in sys.argv[1:] if sys.platform == "linux" else []:
    try:
        ctypes.CDLL(name)
    except OSError:
        print(name)
' "$@"
}

if [ "$purpose" = test ] || [ "$purpose" = bars ]; then
    libraries=$(lacking libGL.so.1 libX11.so.6 libXext.so.6 libSM.so.6 libglib-2.0.so.0)
    [ -z "$libraries" ] || missing "libraries that the judges link: $(echo $libraries) (Debian: apt install libgl1 \
libxext6 libsm6 libglib2.0-0)"
fi
if [ "$purpose" = test ]; then
    for tool in fmt clippy; do
        "${CARGO:-cargo}" $tool --version >/dev/null 2>&1 ||
            missing "cargo $tool; run: rustup component add rustfmt clippy"
    done
    # Whether it also works is for the tests to find out, which then fail.
    [ "${TABLETOPGEN_GPU_TESTS:-require}" != require ] ||
        [ -z "$(lacking libEGL.so.1)" ] || [ -z "$(lacking libvulkan.so.1)" ] ||
        missing "an OpenGL or Vulkan driver for the tests of the GPU kernels, a software one will do (Debian: apt install \
libegl1 libgl1-mesa-dri, or mesa-vulkan-drivers); TABLETOPGEN_GPU_TESTS=optional does without"
fi
echo "$python"
