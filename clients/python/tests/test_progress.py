"""Progress on standard error."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import pytest

from tabletopgen._progress import Bar, is_kernel, is_watched
from tabletopgen.models import Event


def finished(stage: str) -> Event:
    return Event.model_validate(
        {"seq": 1, "at": "2026-01-31T12:00:00Z", "kind": "stage_finished", "data": {"stage": stage, "instance": "mug_1"}}
    )


def test_nothing_is_shown_where_no_one_sees_it(capfd: pytest.CaptureFixture[str]) -> None:
    with Bar(None, "scene") as bar:
        bar.show_event(finished("certify"))
    assert capfd.readouterr() == ("", "")


def test_a_kernel_shows_progress_and_a_program_that_imports_ipython_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    shell = SimpleNamespace()
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    assert not is_kernel()
    shell.kernel = object()
    assert is_kernel() and is_watched()


def test_stages_are_counted_by_tqdm(capfd: pytest.CaptureFixture[str]) -> None:
    with Bar(True, "scene") as bar:
        bar.show_event(finished("certify"))
        bar.show_event(finished("bundle"))
    # An unbounded bar of tqdm is no truth value.
    assert bar.count == 2 and "scene: " in capfd.readouterr().err


def test_a_line_is_written_without_tqdm(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with Bar(True, "scenes", 5) as bar:
        bar.show(3, "a mug")
    shown = capfd.readouterr().err
    assert "scenes: 3/5 a mug (0 s)" in shown and shown.endswith("\r\x1b[K"), "the line is removed at the end"
