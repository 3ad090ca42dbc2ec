"""The judges whose program has no packages for this Python, with the reason."""

import sys

# As the marker in requirements.txt says.
LEFT_OUT = {"bullet": "PyBullet has no packages for Python 3.12 and later"} if sys.version_info >= (3, 12) else {}
