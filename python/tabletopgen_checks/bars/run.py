"""Runs one bar as a program: a broken promise is exit code 1, said in a sentence."""

import sys

from tabletopgen_checks.problem import Problem


def run(bar) -> None:
    try:
        held = bar()
    except Problem as problem:
        print(f"the bar could not be measured: {problem}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)
    print("the bar holds" if held else "THE BAR DOES NOT HOLD", flush=True)
    sys.exit(0 if held else 1)
