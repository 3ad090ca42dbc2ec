"""Records the scene of tests/fixtures/cassettes/ again, from `tabletopgen-lab mock-vendors`.

    PYTHONPATH=python python3 -m tabletopgen_checks.service.cassette [--binary target/release/tabletopgen]

After a change of prompts, of requests or of what the stand-in answers the test of the recording says that something was
not recorded; then this makes the archive anew.
"""

import argparse
import subprocess
import tempfile
import zipfile
from pathlib import Path

from tabletopgen_checks.repository import ROOT
from tabletopgen_checks.service.mock_vendors import MockVendors

FOLDER = ROOT / "tests/fixtures/cassettes"
ADDRESS = "127.0.0.1:18093"
TEXT, SEED = "an apple on a plate and a fork beside it", "7"

# The archive is the same whenever it is made.
DATE = (1980, 1, 1, 0, 0, 0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=Path, default=ROOT / "target/release/tabletopgen")
    binary = parser.parse_args().binary
    with MockVendors(binary, listen=ADDRESS), tempfile.TemporaryDirectory() as work:
        recording = Path(work) / "recording"
        command = [binary, "generate", "--text", TEXT, "--seed", SEED, "--out", Path(work) / "out"]
        command += ["--config", FOLDER / "breakfast.toml", "--set", "providers.mode=record"]
        command += ["--set", f"providers.cassette={recording}"]
        subprocess.run(command, check=True, timeout=1200)
        archive = FOLDER / "breakfast.zip"
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as packed:
            for path in sorted(recording.iterdir()):
                packed.writestr(zipfile.ZipInfo(path.name, DATE), path.read_bytes(), zipfile.ZIP_DEFLATED)
        print(f"{archive}: {len(list(recording.iterdir()))} exchanges, {archive.stat().st_size} bytes")


if __name__ == "__main__":
    main()
