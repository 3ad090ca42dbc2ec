"""The reader of fences in documents, and the shell that runs them."""

import subprocess
import tempfile
import unittest
from pathlib import Path

from tabletopgen_checks import documents as documented
from tabletopgen_checks.problem import Problem

TEXT = """# Title

```sh
one=1
echo first
```

```output
first
```

```sh exit=3
echo "then $one" && exit_with() { return 3; }
exit_with
```

```python
print("third")
```

```
tabletopgen serve
```

```json
{}
```
"""


class Reading(unittest.TestCase):
    def test_fences_have_place_language_and_options(self):
        found = documented.fences("guide.md", TEXT)
        self.assertEqual([fence.language for fence in found], ["sh", "output", "sh", "python", "", "json"])
        self.assertEqual([fence.exit_code for fence in found], [0, 0, 3, 0, 0, 0])
        self.assertEqual((found[0].place, found[0].text), ("guide.md:3", "one=1\necho first"))
        with self.assertRaises(Problem):
            documented.fences("guide.md", "```sh\necho")

    def test_slow_fences_are_left_out_with_their_outputs(self):
        every = documented.fences("guide.md", TEXT.replace("```sh\n", "```sh slow exit=2\n"))
        self.assertEqual((every[0].is_slow, every[0].exit_code), (True, 2))
        kept = documented.without_slow(every)
        self.assertEqual([fence.language for fence in kept], ["sh", "python", "", "json"])
        self.assertEqual(documented.without_slow(kept), kept)

    def test_commands_run_or_are_left_out_for_a_reason(self):
        every = documented.fences("guide.md", TEXT)
        reason = {("guide.md", "tabletopgen serve"): "it does not end"}
        self.assertEqual(documented.complaints(every, reason), [])
        self.assertIn("guide.md:21: begin the fence", documented.complaints(every, {})[0])
        stale = documented.complaints(every, reason | {("guide.md", "tabletopgen gone"): "it went"})
        self.assertEqual(len(stale), 1)
        self.assertIn("does not have: tabletopgen gone", stale[0])
        for line in ("curl -s localhost:8080/scenes", "SCENE=$(x) curl x", "target/release/tabletopgen parse x", "make demo"):
            self.assertTrue(documented.COMMAND.match(line), line)
        for line in ("v1/", "scene 0547 PASS", "[store]", '{"custom_id": "a"}', "; put the apple in the bowl"):
            self.assertFalse(documented.COMMAND.match(line), line)

    def test_the_documents_of_the_repository_are_complete(self):
        every = [
            fence
            for group in documented.GROUPS
            for name in group
            for fence in documented.fences(name, (documented.ROOT / name).read_text(encoding="utf-8"))
        ]
        self.assertEqual(documented.complaints(every, documented.LEFT_OUT), [])
        self.assertGreater(sum(fence.language == "sh" for fence in every), 15)

    def test_an_output_is_compared_line_by_line(self):
        self.assertTrue(documented.same("a\nb", "a\nb\n"))
        self.assertFalse(documented.same("a\nb", "a\nb\nc\n"))
        self.assertTrue(documented.same("a\n...", "a\nb\nc\n"))
        self.assertTrue(documented.same("a\n...\nc", "a\nb\nb\nc\n"))
        self.assertTrue(documented.same("...\nc", "a\nc\n"))
        self.assertFalse(documented.same("a\n...", "b\na\n"))
        self.assertFalse(documented.same("a.c", "abc\n"))
        self.assertTrue(documented.same("N of NaN in N s", "12 of NaN in 3.5 s\n"))
        self.assertFalse(documented.same("N s", "many s\n"))


class Running(unittest.TestCase):
    def run_script(self, text):
        with tempfile.TemporaryDirectory() as home:
            every = documented.fences("guide.md", text)
            words = documented.script(every, Path(home))
            code = subprocess.run(["bash", "-c", words], cwd=home, capture_output=True).returncode
            outputs = {path.name: path.read_text(encoding="utf-8") for path in Path(home).glob("*.out")}
            return code, (Path(home) / "begun").read_text(encoding="utf-8").strip(), outputs

    def test_fences_share_one_shell_and_leave_their_outputs(self):
        code, begun, outputs = self.run_script(TEXT)
        self.assertEqual((code, begun), (0, "end"))
        self.assertEqual(outputs, {"0.out": "first\n", "2.out": "then 1\n", "3.out": "third\n"})

    def test_the_first_command_that_fails_ends_it(self):
        code, begun, _ = self.run_script(TEXT.replace("echo first", "false\necho first"))
        self.assertEqual((code, begun), (1, "0"))
        code, begun, _ = self.run_script(TEXT.replace("return 3", "return 4"))
        self.assertEqual((code, begun), (99, "2"))
        code, begun, _ = self.run_script(TEXT.replace('print("third")', "missing"))
        self.assertEqual((code, begun), (1, "3"))
        code, begun, _ = self.run_script(TEXT.replace("echo first", "x=$(false | cat)\necho first"))
        self.assertEqual((code, begun), (1, "0"), "also in a pipe")


if __name__ == "__main__":
    unittest.main()
