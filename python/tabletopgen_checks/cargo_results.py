"""What `cargo test` says over many test programs, as one result."""

import re
from dataclasses import dataclass, field

COLORS = re.compile(r"\x1b\[[0-9;]*m")
# Standard error and output in one stream: cargo names a program, then the program speaks.
PROGRAM = re.compile(r"^\s+Running (?:unittests )?\S+ \((?:.*[/\\])?([^/\\]+?)(?:-[0-9a-f]{16})?(?:\.exe)?\)$")
DOCUMENTATION = re.compile(r"^\s+Doc-tests (\S+)$")
RESULT = re.compile(r"^test result: (?:ok|FAILED)\. (\d+) passed; (\d+) failed; (\d+) ignored;")
FAILING = re.compile(r"^    (\S.*)$")
# Within a line where the program ended within one.
RERUN = re.compile(r"error: (?:test|doctest) failed, to rerun pass `(.+)`$")
NAMED = 20


@dataclass
class Results:
    passed: int = 0
    failed: int = 0
    ignored: int = 0
    programs: int = 0
    # Each as "name (program)".
    failing: list = field(default_factory=list)
    # cargo's arguments for each program that did not pass, those included that broke off without a result.
    reruns: list = field(default_factory=list)

    def summary(self) -> str:
        return f"{self.passed} passed, {self.ignored} ignored in {counted(self.programs, 'test program')}"

    def complaint(self) -> str:
        """Empty where cargo names no program that failed."""
        words = []
        if self.failing:
            more = f" and {len(self.failing) - NAMED} more" if len(self.failing) > NAMED else ""
            words.append(f"{counted(len(self.failing), 'test')} failed: {', '.join(self.failing[:NAMED])}{more}")
        if self.reruns:
            words.append("to run again: " + ", ".join(f"`cargo test {arguments}`" for arguments in self.reruns))
        return "; ".join(words)


def counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def read(lines) -> Results:
    results, program, names = Results(), "", None
    for line in lines:
        line = COLORS.sub("", line.rstrip("\n"))
        if found := PROGRAM.match(line) or DOCUMENTATION.match(line):
            program, names = found[1], None
            results.programs += 1
        elif line == "failures:":
            # It stands above what the tests printed, which may hold it too, and at last above their names.
            names = []
        elif names is not None and (found := FAILING.match(line)):
            names.append(f"{found[1]} ({program})")
        elif found := RESULT.match(line):
            results.passed += int(found[1])
            results.failed += int(found[2])
            results.ignored += int(found[3])
            results.failing += names or []
            names = None
        elif found := RERUN.search(line):
            results.reruns.append(found[1])
    return results
