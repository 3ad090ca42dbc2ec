"""What C code prints to standard output and error while a block runs."""

import ctypes
import os
import sys
import tempfile

_c = ctypes.CDLL(None)


def _flush():
    sys.stdout.flush()
    sys.stderr.flush()
    _c.fflush(None)


class Overheard:
    """Redirects file descriptors 1 and 2; afterwards `text` holds what was printed."""

    def __enter__(self):
        _flush()
        self.file = tempfile.TemporaryFile()
        self.saved = [os.dup(1), os.dup(2)]
        os.dup2(self.file.fileno(), 1)
        os.dup2(self.file.fileno(), 2)
        return self

    def __exit__(self, *_):
        _flush()
        for number, saved in zip((1, 2), self.saved):
            os.dup2(saved, number)
            os.close(saved)
        self.file.seek(0)
        self.text = self.file.read().decode("utf-8", "replace")
        self.file.close()
