"""The tar archive that the writer of datasets must produce, as Python reads and writes it."""

import io
import tarfile
import unittest

from tabletopgen_checks.repository import ROOT

FIXTURE = ROOT / "tests/fixtures/datasets/shard.tar"
MEMBERS = {"scene00.json": b"{}\n", "scene00.zip": b"P" * 600}


class Shard(unittest.TestCase):
    def test_tarfile_reads_members_without_time_and_owner(self):
        with tarfile.open(FIXTURE) as archive:
            members = archive.getmembers()
            self.assertEqual([member.name for member in members], list(MEMBERS))
            for member in members:
                content = archive.extractfile(member)
                assert content is not None
                self.assertEqual(content.read(), MEMBERS[member.name])
                self.assertEqual((member.mtime, member.uid, member.gid, member.mode), (0, 0, 0, 0o644))
                self.assertEqual((member.uname, member.gname), ("", ""))

    def test_tarfile_writes_the_same_bytes(self):
        buffer = io.BytesIO()
        with tarfile.open(fileobj=buffer, mode="w", format=tarfile.USTAR_FORMAT) as archive:
            for name, content in MEMBERS.items():
                member = tarfile.TarInfo(name)
                member.size = len(content)
                archive.addfile(member, io.BytesIO(content))
        expected = FIXTURE.read_bytes()
        written = buffer.getvalue()
        self.assertEqual(written[: len(expected)], expected)
        # Python fills the last record; two empty blocks end the archive.
        self.assertFalse(any(written[len(expected) :]))
        self.assertEqual(expected[-1024:], bytes(1024))


if __name__ == "__main__":
    unittest.main()
