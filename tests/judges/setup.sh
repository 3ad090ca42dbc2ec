#!/bin/sh
# Makes the judges' environment under target/judges: a Python venv with requirements.txt and, through the
# Node.js that comes with it, the Khronos glTF validator. Does nothing (and needs no network) when the
# environment was made from the same files in the same place. Prints nothing when all is well.
set -eu

here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
venv=${JUDGES_VENV:-$here/../../target/judges}
gltf_validator=2.0.0-dev.3.10

python=
for candidate in "${PYTHON:-}" python3.11 python3; do
    [ -n "$candidate" ] && command -v "$candidate" >/dev/null 2>&1 || continue
    if "$candidate" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' 2>/dev/null; then
        python=$candidate
        break
    fi
done
if [ -z "$python" ]; then
    echo "missing prerequisite: Python 3.11 (pybullet has no wheels for later versions); set PYTHON to it" >&2
    exit 3
fi

# The scripts of a venv name its interpreter by an absolute path: one that was moved is made anew.
stamp=$("$python" - "$here/requirements.txt" "$gltf_validator" "$venv" <<'PY'
import hashlib, os, sys
requirements, validator, venv = sys.argv[1:]
told = open(requirements, "rb").read() + validator.encode() + os.path.realpath(venv).encode()
print(hashlib.sha256(told).hexdigest())
PY
)
if [ -f "$venv/stamp" ] && [ "$(cat "$venv/stamp")" = "$stamp" ] && [ -x "$venv/bin/python" ]; then
    exit 0
fi

if [ -f "$venv/pyvenv.cfg" ]; then
    rm -rf "$venv"
fi
if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
    echo "missing prerequisite: the venv module of $python (Debian: apt install python3.11-venv)" >&2
    exit 3
fi
mkdir -p "$venv"
"$python" -m venv "$venv"
if ! "$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$here/requirements.txt"; then
    echo "missing prerequisite: PyPI could not deliver tests/judges/requirements.txt (see above)" >&2
    exit 3
fi
# npm needs the wheel's node on the PATH.
if ! PATH="$venv/bin:$PATH" "$venv/bin/npm" install --silent --no-audit --no-fund --no-save \
    --prefix "$venv/node" "gltf-validator@$gltf_validator" >"$venv/npm.log" 2>&1; then
    cat "$venv/npm.log" >&2
    echo "missing prerequisite: npm could not deliver gltf-validator $gltf_validator" >&2
    exit 3
fi
echo "$stamp" >"$venv/stamp"
