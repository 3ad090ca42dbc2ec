"""A made-up machine: a folder of programs that is the whole PATH."""

import subprocess
import sys
import tempfile
from pathlib import Path

from tabletopgen_checks.repository import SCRIPTS

# A Python that says it is of another version, and may lack modules or libraries.
PYTHON = """#!/bin/sh
shift
exec "{real}" -c '
import ctypes, sys
def load(name):
    if not {loads}:
        raise OSError(name)
ctypes.CDLL = load
sys.version_info = ({version}, 0, "final", 0)
for name in "{lacks}".split():
    sys.modules[name] = None
code = sys.argv.pop(1)
sys.argv[0] = "-c"
exec(code)
' "$@"
"""


class Machine:
    """A context manager; `path` is the folder."""

    def __enter__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = Path(self.folder.name)
        for program in ("sh", "dirname", "cat"):
            found = next(Path(folder) / program for folder in ("/bin", "/usr/bin") if (Path(folder) / program).exists())
            (self.path / program).symlink_to(found)
        return self

    def __exit__(self, *_):
        self.folder.cleanup()

    def program(self, name: str, words: str = "#!/bin/sh\n") -> Path:
        path = self.path / name
        path.write_text(words, encoding="utf-8")
        path.chmod(0o755)
        return path

    def python(self, name: str, version: str, lacks: str = "", loads: bool = True) -> str:
        """`version` as in 3.13; `lacks` names modules; `loads`: whether the system has the libraries it is asked
        for."""
        words = PYTHON.format(real=sys.executable, version=version.replace(".", ", "), lacks=lacks, loads=loads)
        return str(self.program(name, words))

    def run(self, script: str, *arguments, **environment):
        """A shell script of `scripts/`: its exit code, output and errors."""
        done = subprocess.run(
            ["/bin/sh", str(SCRIPTS / script), *map(str, arguments)],
            env={"PATH": str(self.path), **environment},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
        )
        return done.returncode, done.stdout.strip(), done.stderr.strip()
