"""Progress on a terminal or in a notebook: a bar of `tqdm` where that is installed, else one line."""

from __future__ import annotations

import contextlib
import importlib
import sys
import time
import warnings
from types import TracebackType
from typing import Any

from tabletopgen.models import Event


def is_watched() -> bool:
    """Whether someone sees standard error: a terminal, or the kernel of a notebook."""
    return sys.stderr.isatty() or is_kernel()


def is_kernel() -> bool:
    """Whether this process is the kernel of a notebook; its packages may be imported elsewhere."""
    ipython = sys.modules.get("IPython")
    return hasattr(ipython.get_ipython(), "kernel") if ipython else False


class Bar:
    """A count with words beside it. Without a total it counts up."""

    def __init__(self, shown: bool | None, title: str, total: int | None = None):
        self.shown = is_watched() if shown is None else shown
        self.title, self.total, self.count = title, total, 0
        self.began = time.monotonic()
        self.tqdm: Any = None

    def __enter__(self) -> Bar:
        if self.shown:
            with contextlib.suppress(ImportError), warnings.catch_warnings():
                # Without ipywidgets the bar of a notebook is a line, which is well.
                warnings.simplefilter("ignore")
                self.tqdm = importlib.import_module("tqdm.auto").tqdm(desc=self.title, total=self.total, leave=False)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self.tqdm is not None:
            self.tqdm.close()
        elif self.shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()

    def show(self, count: int, words: str) -> None:
        """Sets the count and the words."""
        if self.tqdm is not None:
            self.tqdm.set_postfix_str(words, refresh=False)
            self.tqdm.update(count - self.count)
        elif self.shown:
            of = f"{count}/{self.total}" if self.total else str(count)
            line = f"{self.title}: {of} {words} ({time.monotonic() - self.began:.0f} s)"
            sys.stderr.write(f"\r\x1b[K{line[:100]}")
            sys.stderr.flush()
        self.count = count

    def show_event(self, event: Event) -> None:
        """Counts finished stages."""
        if event.data.stage:
            words = f"{event.data.stage} {event.data.instance or ''}".strip()
            self.show(self.count + (event.kind == "stage_finished"), words)
