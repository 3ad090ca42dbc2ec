"""Which Python the scripts take, of those that a machine has."""

import unittest

from tabletopgen_checks.tests.machine import Machine


class Chosen(unittest.TestCase):
    def setUp(self):
        self.machine = self.enterContext(Machine())

    def test_the_first_version_in_the_range_is_taken(self):
        self.machine.python("python3", "3.14")
        wanted = self.machine.python("python3.12", "3.12")
        self.assertEqual(self.machine.run("python.sh", "3.11", "3.14"), (0, wanted, ""))

    def test_the_version_that_every_judge_has_packages_for_goes_before_later_ones(self):
        self.machine.python("python3.13", "3.13")
        wanted = self.machine.python("python3.11", "3.11")
        self.assertEqual(self.machine.run("python.sh", "3.11", "3.14"), (0, wanted, ""))

    def test_both_ends_belong_to_the_range(self):
        for version in ("3.11", "3.14"):
            wanted = self.machine.python("python3", version)
            self.assertEqual(self.machine.run("python.sh", "3.11", "3.14"), (0, wanted, ""))

    def test_others_are_refused(self):
        for version in ("2.7", "3.8", "3.10", "3.15", "4.0"):
            self.machine.python("python3", version)
            code, found, words = self.machine.run("python.sh", "3.11", "3.14")
            self.assertEqual((code, found), (1, ""), version)
            self.assertEqual(words, "Python 3.11 to 3.14; install it or set PYTHON to it")

    def test_a_range_without_end_takes_every_later_one(self):
        wanted = self.machine.python("python", "3.21")
        self.assertEqual(self.machine.run("python.sh", "3.9", "later"), (0, wanted, ""))
        self.machine.python("python", "3.8")
        code, _, words = self.machine.run("python.sh", "3.9", "later")
        self.assertEqual((code, words), (1, "Python 3.9 or later; install it or set PYTHON to it"))

    def test_one_without_venv_is_passed_over_and_named_where_there_is_no_other(self):
        lacking = "ensurepip"
        self.machine.python("python3.11", "3.11", lacking)
        wanted = self.machine.python("python3.13", "3.13")
        self.assertEqual(self.machine.run("python.sh", "3.11", "3.14", "venv"), (0, wanted, ""))
        self.machine.python("python3.13", "3.13", lacking)
        code, _, words = self.machine.run("python.sh", "3.11", "3.14", "venv")
        self.assertEqual((code, words), (1, "the venv module of python3.13 (Debian: apt install python3.13-venv)"))

    def test_a_name_that_does_not_run_is_passed_over(self):
        self.machine.program("python3.11", "#!/bin/sh\necho 'no such version' >&2\nexit 127\n")
        wanted = self.machine.python("python3.12", "3.12")
        self.assertEqual(self.machine.run("python.sh", "3.11", "3.14"), (0, wanted, ""))

    def test_the_one_that_is_named_is_taken_or_nothing(self):
        self.machine.python("python3.11", "3.11")
        named = self.machine.python("my python", "3.13")
        self.assertEqual(self.machine.run("python.sh", "3.11", "3.14", PYTHON=named), (0, named, ""))
        code, found, words = self.machine.run("python.sh", "3.11", "3.11", PYTHON=named)
        self.assertEqual((code, found, words), (1, "", f"Python 3.11, which PYTHON={named} is not"))


class Prerequisites(unittest.TestCase):
    def setUp(self):
        self.machine = self.enterContext(Machine())
        for name in ("cargo", "cc", "c++"):
            self.machine.program(name)

    def run_for(self, *purpose, **environment):
        return self.machine.run("prerequisites.sh", *purpose, TABLETOPGEN_GPU_TESTS="optional", **environment)

    def test_the_demo_takes_any_python_from_3_9_or_none(self):
        self.assertEqual(self.run_for("demo"), (0, "", ""))
        self.machine.python("python3", "3.8")
        self.assertEqual(self.run_for("demo"), (0, "", ""))
        wanted = self.machine.python("python3", "3.9", "ensurepip")
        self.assertEqual(self.run_for("demo"), (0, wanted, ""))

    def test_the_demo_refuses_an_old_python_that_was_named(self):
        old = self.machine.python("old", "3.8")
        words = f"missing prerequisite: Python 3.9 or later, which PYTHON={old} is not"
        self.assertEqual(self.run_for("demo", PYTHON=old), (3, "", words))

    def test_the_tests_take_3_11_to_3_14(self):
        for version in ("3.11", "3.12", "3.13", "3.14"):
            wanted = self.machine.python("python3", version)
            self.assertEqual(self.run_for(), (0, wanted, ""))
        self.machine.python("python3", "3.10")
        self.assertEqual(self.run_for("test")[0], 3)

    def test_the_bars_take_only_the_version_that_every_judge_has_packages_for(self):
        wanted = self.machine.python("python3", "3.11")
        self.assertEqual(self.run_for("bars"), (0, wanted, ""))
        self.machine.python("python3", "3.12")
        words = "missing prerequisite: Python 3.11; install it or set PYTHON to it"
        self.assertEqual(self.run_for("bars"), (3, "", words))

    def test_libraries_that_the_judges_link_are_asked_for(self):
        wanted = self.machine.python("python3", "3.11", loads=False)
        self.assertEqual(self.run_for("demo"), (0, wanted, ""))
        for purpose in ("test", "bars"):
            code, _, words = self.run_for(purpose)
            self.assertEqual(code, 3)
            self.assertIn("libraries that the judges link: libGL.so.1 libX11.so.6", words)

    def test_a_build_asks_for_no_python(self):
        self.assertEqual(self.run_for("build"), (0, "", ""))

    def test_what_is_missing_is_named(self):
        (self.machine.path / "c++").unlink()
        self.assertIn("a C++ compiler named c++", self.run_for("build")[2])
        (self.machine.path / "cc").unlink()
        self.assertIn("a C compiler named cc", self.run_for("build")[2])
        (self.machine.path / "cargo").unlink()
        self.assertIn("a Rust toolchain", self.run_for("build")[2])

    def test_a_purpose_that_is_none_is_refused(self):
        self.assertEqual(self.run_for("dmeo")[0], 2)


if __name__ == "__main__":
    unittest.main()
