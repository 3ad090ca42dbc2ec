"""Pages of results say what was measured."""

import contextlib
import io
import sys
import unittest
from unittest import mock

from tabletopgen_checks.bars import page


class Commits(unittest.TestCase):
    def setUp(self):
        page.commit_at_the_begin.cache_clear()
        self.addCleanup(page.commit_at_the_begin.cache_clear)

    def begin(self, changes: str, *words):
        with (
            mock.patch.object(page, "git", lambda *asked: "abc" if asked[0] == "rev-parse" else changes),
            mock.patch.object(sys, "argv", ["bar", "--target-dir", "/tmp/no_target", *words]),
            mock.patch.object(page.Path, "mkdir"),
        ):
            return page.arguments("a bar"), page.measured_commit()

    def test_a_clean_tree_is_measured_without_a_mark(self):
        self.assertEqual(self.begin("")[1], "abc")

    def test_uncommitted_changes_are_refused_before_anything_is_measured(self):
        errors = io.StringIO()
        with contextlib.redirect_stderr(errors), self.assertRaises(SystemExit):
            self.begin(" M src/lib.rs")
        self.assertIn("abc with uncommitted changes: commit or stash them, or give --uncommitted", errors.getvalue())

    def test_uncommitted_changes_that_are_wanted_are_marked(self):
        self.assertEqual(self.begin(" M src/lib.rs", "--uncommitted")[1], "abc with uncommitted changes")

    def test_a_tree_that_changes_on_the_way_is_marked(self):
        self.begin("")
        with mock.patch.object(page, "git", lambda *asked: "def" if asked[0] == "rev-parse" else ""):
            self.assertEqual(page.measured_commit(), "abc with uncommitted changes")

    def test_a_page_names_the_options_that_say_how_much_is_measured(self):
        words = ["bar", "--target-dir", "/tmp/t", "--only", "one", "--uncommitted", "--count", "20", "--program", "/tmp/p"]
        with mock.patch.object(sys, "argv", words):
            self.assertEqual(page.options_given(), "--only one --count 20")
        with mock.patch.object(sys, "argv", ["bar", "--target-dir", "/tmp/t"]):
            self.assertEqual(page.options_given(), "")


if __name__ == "__main__":
    unittest.main()
