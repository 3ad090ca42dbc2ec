#!/bin/sh
# Makes the judges' environment under target/judges: a Python venv with requirements.txt and later_pythons.txt and,
# through the Node.js that comes with it, the Khronos glTF validator. Does nothing (and needs no network) when the
# environment was made from the same files by the same Python in the same place. Prints nothing when all is well.
set -eu

here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
venv=${JUDGES_VENV:-$here/../../target/judges}
gltf_validator=2.0.0-dev.3.10

if ! python=$("$here/../../scripts/python.sh" 3.11 3.14 venv 2>&1); then
    echo "missing prerequisite: $python" >&2
    exit 3
fi

# The scripts of a venv name its interpreter by an absolute path: one that was moved is made anew.
stamp=$("$python" - "$here/requirements.txt" "$here/later_pythons.txt" "$gltf_validator" "$venv" <<'PY'
import hashlib, os, sys
*files, validator, venv = sys.argv[1:]
whole = hashlib.sha256()
for path in files:
    with open(path, "rb") as file:
        whole.update(file.read() + b"\0")
whole.update(f"{validator} {os.path.realpath(venv)} {sys.version_info[:2]}".encode())
print(whole.hexdigest())
PY
)
if [ -f "$venv/stamp" ] && [ "$(cat "$venv/stamp")" = "$stamp" ] && [ -x "$venv/bin/python" ]; then
    exit 0
fi

if [ -f "$venv/pyvenv.cfg" ]; then
    rm -rf "$venv"
fi
mkdir -p "$venv"
"$python" -m venv "$venv"
install() {
    file=$1
    shift
    if ! "$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$here/$file" "$@"; then
        echo "missing prerequisite: PyPI could not deliver tests/judges/$file (see above)" >&2
        exit 3
    fi
}
install requirements.txt
install later_pythons.txt --no-deps --ignore-requires-python
# npm needs the wheel's node on the PATH.
if ! PATH="$venv/bin:$PATH" "$venv/bin/npm" install --silent --no-audit --no-fund --no-save \
    --prefix "$venv/node" "gltf-validator@$gltf_validator" >"$venv/npm.log" 2>&1; then
    cat "$venv/npm.log" >&2
    echo "missing prerequisite: npm could not deliver gltf-validator $gltf_validator" >&2
    exit 3
fi
echo "$stamp" >"$venv/stamp"
