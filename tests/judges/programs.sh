#!/bin/sh
# Makes an environment of its own for each program of the README's examples that cannot share the judges':
# Newton wants older versions of MuJoCo and OpenUSD, Blender an older NumPy. Two gigabytes; `make test` does
# without them. Does nothing for a program whose environment is there.
set -eu

here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
venv=${JUDGES_VENV:-$here/../../target/judges}
for program in newton blender; do
    requirements=$here/programs/$program.txt
    folder=$venv/programs/$program
    if [ -f "$folder/stamp" ] && cmp -s "$folder/stamp" "$requirements"; then
        continue
    fi
    rm -rf "$folder"
    mkdir -p "$folder"
    "$venv/bin/python" -m venv "$folder"
    "$folder/bin/python" -m pip install --quiet --disable-pip-version-check -r "$requirements"
    cp "$requirements" "$folder/stamp"
done
