"""What python/tabletopgen_checks/test.py reads from the words of `cargo test`."""

import unittest

from tabletopgen_checks import cargo_results

PASSING = """\
   Compiling tabletopgen v0.1.0
    Finished `test` profile [optimized + debuginfo] target(s) in 2.01s
     Running unittests src/lib.rs (target/debug/deps/geometry-b194e7e1cb7381c5)

running 2 tests
test plane::touches ... ok
test result: ok. is what a test may print
test plane::slow ... ignored, takes minutes

test result: ok. 1 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.00s

     Running tests/it/main.rs (/elsewhere/target/debug/deps/it-902e0760cb650638)

running 40 tests

test result: ok. 40 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 9.12s

   Doc-tests geometry

running 0 tests

test result: ok. 0 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s

""".splitlines(keepends=True)

FAILING = """\
     Running unittests src/lib.rs (target/debug/deps/scene-b194e7e1cb7381c5)

running 2 tests
test units::meters ... FAILED
test units::grams ... ok

failures:

---- units::meters stdout ----

thread 'units::meters' panicked at crates/base/scene/src/units.rs:7:5:
failures:
    a line that the test printed
note: run with `RUST_BACKTRACE=1`


failures:
    units::meters

test result: FAILED. 1 passed; 1 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s

\x1b[1m\x1b[31merror\x1b[0m: test failed, to rerun pass `-p tabletopgen-scene --lib`
     Running tests/it/main.rs (target/debug/deps/it-902e0760cb650638)

running 3 tests
test breaks::off ... error: test failed, to rerun pass `-p tabletopgen --test it`

Caused by:
  process didn't exit successfully: `it-902e0760cb650638` (signal: 11, SIGSEGV: invalid memory reference)
   Doc-tests scene

running 1 test

test result: ok. 1 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s

error: 2 targets failed:
    `-p tabletopgen-scene --lib`
    `-p tabletopgen --test it`
""".splitlines(keepends=True)


class Read(unittest.TestCase):
    def test_every_program_counts(self):
        results = cargo_results.read(PASSING)
        self.assertEqual(results.summary(), "41 passed, 1 ignored in 3 test programs")
        self.assertEqual(results.complaint(), "")

    def test_failures_are_named_with_their_program(self):
        results = cargo_results.read(FAILING)
        self.assertEqual((results.passed, results.failed, results.programs), (2, 1, 3))
        self.assertEqual(results.failing, ["units::meters (scene)"])

    def test_a_program_that_broke_off_is_named(self):
        reruns = cargo_results.read(FAILING).reruns
        self.assertEqual(reruns, ["-p tabletopgen-scene --lib", "-p tabletopgen --test it"])
        words = "1 test failed: units::meters (scene); to run again: `cargo test -p tabletopgen-scene --lib`, "
        self.assertEqual(cargo_results.read(FAILING).complaint(), words + "`cargo test -p tabletopgen --test it`")

    def test_nothing_is_made_of_a_failed_build(self):
        results = cargo_results.read(["error[E0308]: mismatched types\n", "error: could not compile `scene`\n"])
        self.assertEqual((results.passed, results.programs, results.complaint()), (0, 0, ""))


if __name__ == "__main__":
    unittest.main()
