#!/bin/sh
# `make demo` where there is no Python: the scenes of tabletopgen_checks.demo, made by the command line instead of the server.
#
#     scripts/demo.sh target/release/tabletopgen [out]
set -eu

binary=$1 out=${2:-out}
text="A wooden desk with a laptop, a mug with two pencils in it, three books stacked on each other, a plate with two apples and a potted plant"
image=$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)/docs/demo_table.png

generate() {
    name=$1
    shift
    if ! "$binary" generate "$@" --seed 7 --out "$out/$name" --force; then
        echo "the demo did not finish: no scene came of the $name; see above" >&2
        exit 1
    fi
    echo
}

echo "no Python 3.9 or later is here: the demo does without the server, and makes the same scenes by the command line"
echo
echo "the sentence: $text"
generate sentence --text "$text"
echo "the image: $image"
generate image --image "$image"
echo "done; see $out/sentence/preview and $out/image/preview,"
echo "or load a scene as the README.md beside it says"
