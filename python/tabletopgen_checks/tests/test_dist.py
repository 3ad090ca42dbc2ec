"""The archive that `make dist` packs."""

import io
import json
import tarfile
import tempfile
import unittest
from pathlib import Path

from tabletopgen_checks import dist


def crate(folder: Path, name: str, license: str = "MIT/Apache-2.0") -> dict:
    (folder / name).mkdir()
    return {
        "name": name,
        "version": "1.0.0+abc",
        "license": license,
        "description": " Does something.\n",
        "authors": ["Ada"],
        "repository": "https://example.org",
        "manifest_path": str(folder / name / "Cargo.toml"),
    }


class DistTest(unittest.TestCase):
    def test_each_license_text_is_there_once_with_its_packages(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            crates = [crate(folder, name) for name in ("first", "second", "vendored", "bare")]
            (folder / "first" / "LICENSE-MIT").write_text("Text of a license.\n")
            (folder / "second" / "license.txt").write_text("Text of a license.")
            (folder / "vendored" / "upstream").mkdir()
            (folder / "vendored" / "upstream" / "COPYING").write_text("Another text.")
            texts = dist.license_texts(crates)
        self.assertEqual(texts.count("Text of a license."), 1)
        self.assertIn("Of first 1.0.0+abc (MIT/Apache-2.0), second 1.0.0+abc (MIT/Apache-2.0):", texts)
        self.assertIn("Another text.", texts)
        self.assertIn("bare 1.0.0+abc (MIT/Apache-2.0) comes without a text. It is under MIT/Apache-2.0, copyright Ada", texts)

    def test_the_bill_of_materials_names_crates_and_packages_of_the_page(self):
        with tempfile.TemporaryDirectory() as name:
            document = json.loads(dist.bill_of_materials("0.1.0", [crate(Path(name), "first")]))
        by_ref = {part["bom-ref"]: part for part in document["components"]}
        self.assertEqual(by_ref["pkg:cargo/first@1.0.0%2Babc"]["licenses"], [{"expression": "MIT OR Apache-2.0"}])
        names = {part["name"] for part in by_ref.values()}
        self.assertTrue({"three", "preact"} <= names, names)
        self.assertNotIn("vite", names)
        self.assertEqual(set(document["dependencies"][0]["dependsOn"]), set(by_ref))

    def test_the_same_files_make_the_same_bytes(self):
        files = {"b": (b"two", 0o644), "a": (b"one", 0o755)}
        first = dist.packed("name", files)
        self.assertEqual(first, dist.packed("name", dict(reversed(files.items()))))
        with tarfile.open(fileobj=io.BytesIO(first)) as archive:
            self.assertEqual([(entry.name, entry.mode) for entry in archive], [("name/a", 0o755), ("name/b", 0o644)])


if __name__ == "__main__":
    unittest.main()
