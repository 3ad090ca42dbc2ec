"""The age of the pages of results: the commits that they were measured at, and what changed since then.

A page, or a section of it, states "at commit COMMIT on DAY" for what was measured; commits in other words are only
mentioned. The last line of a page names the files and folders that decide its figures: "Depends on
`crates/method/physics`, `src/pipeline`."
"""

import functools
import re
from dataclasses import dataclass

from tabletopgen_checks.repository import RESULTS, git

STATED = re.compile(r"\bat\s+commit\s+([0-9a-f]{7,40})(?:\s+with\s+uncommitted\s+changes)?\s+on\s+(\d{4}-\d\d-\d\d)\b", re.IGNORECASE)
LINE = re.compile(r"\n*^Depends on ((?:`[^`\n]+`(?:, )?)+)\.$\n*\Z", re.MULTILINE)
COLUMNS = ["page", "section", "commit", "day", "commits since", "lines changed"]
MISSING = "not in this clone"


@dataclass(frozen=True)
class Measurement:
    """What a page, or a section of it where that is named, states about its figures."""

    page: str
    section: str
    commit: str
    day: str


def dependency_line(paths) -> str:
    return "Depends on " + ", ".join(f"`{path}`" for path in paths) + "."


def split(page: str) -> tuple:
    """(the page without its line of dependencies, the paths of that line)."""
    found = LINE.search(page)
    return (page[: found.start()].rstrip() + "\n", re.findall("`([^`]+)`", found[1])) if found else (page, [])


def measurements(name: str, page: str) -> list:
    """All of a page, in the order of its text."""
    found, section = [], ""
    for part in re.split(r"^(?=## )", page, flags=re.MULTILINE):
        if part.startswith("## "):
            section = part.split("\n", 1)[0][3:].strip()
        found += [Measurement(name, section, commit, day) for commit, day in STATED.findall(part)]
    return found


@functools.cache
def is_known(commit: str) -> bool:
    return bool(git("rev-parse", "--verify", "--quiet", f"{commit}^{{commit}}"))


@functools.cache
def files_changed(commit: str) -> list:
    """(lines added and removed, name, earlier name) of every file that differs from that commit; binary files have no
    lines.

    The whole tree is compared, so that a file that was moved into a folder is not counted as new there.
    """
    words = git("diff", "--numstat", "-z", "--find-renames", "-l20000", commit, "HEAD").split("\0")
    found = []
    while len(words) > 1:
        added, removed, name = words.pop(0).split("\t")
        # Of a renamed file both names follow.
        earlier, name = (name, name) if name else (words.pop(0), words.pop(0))
        found.append((0 if added == "-" else int(added) + int(removed), name, earlier))
    return found


def changed_since(commit: str, paths: list) -> tuple:
    """(commits after that one, lines that differ from it) in these files and folders."""
    def inside(name):
        return any(name == path or name.startswith(path + "/") for path in paths)
    lines = sum(lines for lines, name, earlier in files_changed(commit) if inside(name) or inside(earlier))
    return int(git("rev-list", "--count", f"{commit}..HEAD", "--", *paths)), lines


def rows() -> list:
    """The oldest measurement of each page or section, how many commits are named there, and what changed since; the
    oldest first.

    What changed is None where the commit is not in this clone.
    """
    found = []
    for path in sorted(RESULTS.glob("*.md")):
        page, paths = split(path.read_text(encoding="utf-8"))
        sections: dict = {}
        for one in measurements(path.name, page):
            since = changed_since(one.commit, paths) if is_known(one.commit) else None
            sections.setdefault(one.section, []).append((one, since))
        for known in sections.values():
            found.append((*min(known, key=from_old_to_young), len({one.commit for one, _ in known})))
    return sorted(found, key=from_old_to_young)


def from_old_to_young(row: tuple) -> tuple:
    one, since, *_ = row
    return one.day, -since[0] if since else 0


def listing() -> str:
    """The rows in columns, and why the age of some is not known."""
    found, cells = rows(), [COLUMNS]
    for one, since, commits in found:
        named = one.commit if commits == 1 else f"{one.commit}, oldest of {commits}"
        cells.append([one.page, one.section, named, one.day, *(map(str, since) if since else (MISSING, ""))])
    widths = [max(map(len, column)) for column in zip(*cells)]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in cells]
    if any(since is None for _, since, _ in found):
        if git("rev-parse", "--is-shallow-repository") == "true":
            lines += ["", f"{MISSING}: this is a shallow clone; `git fetch --unshallow` brings the commits."]
        else:
            lines += ["", f"{MISSING}: no history here has this commit, so the age of its page is not known; measure it again."]
    return "\n".join(lines)
