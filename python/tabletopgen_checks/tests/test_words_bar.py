"""The bar of the words: shares, and scenes that take too long."""

import contextlib
import io
import unittest
from types import SimpleNamespace

from tabletopgen_checks.bars import words as bar


def scenes(**seconds):
    return {name: SimpleNamespace(cpu_s=one) for name, one in seconds.items()}


class Slow(unittest.TestCase):
    def slow(self, found, objects, again=()):
        """The names over the limit; `again` has the seconds of those that are made once more."""
        maker = SimpleNamespace(again=lambda name: SimpleNamespace(cpu_s=dict(again)[name]))
        with contextlib.redirect_stdout(io.StringIO()):
            return [name for name, _ in bar.slow_scenes(maker, {name: name for name in found}, found, objects)]

    def test_the_median_is_that_of_as_many_objects(self):
        objects = dict.fromkeys("abc", 1) | dict.fromkeys("de", 9)
        found = scenes(a=1.0, b=1.0, c=3.1, d=30.0, e=31.0)
        self.assertEqual(self.slow(found, objects, {"c": 3.2}), ["c"])
        self.assertEqual(self.slow(scenes(a=1.0, b=1.0, c=3.0), objects), [])

    def test_a_scene_that_is_quick_alone_is_not_slow(self):
        objects = dict.fromkeys("abc", 1)
        self.assertEqual(self.slow(scenes(a=1.0, b=1.0, c=9.0), objects, {"c": 1.5}), [])

    def test_texts_without_a_scene_have_no_time(self):
        self.assertEqual(self.slow(scenes(a=1.0, b=None), dict.fromkeys("ab", 1)), [])


class Shares(unittest.TestCase):
    def test_shares_reach_their_bar_or_not(self):
        self.assertEqual(bar.at_least("x", 92, 100, 0.92), ("x", "92.0 % of 100", "92 %", True))
        self.assertEqual(bar.at_least("x", 91, 100, 0.92)[3], False)
        self.assertEqual(bar.at_least("x", 995, 1000, 0.995)[2:], ("99.5 %", True))

    def test_of_nothing_no_share_is_reached(self):
        self.assertEqual(bar.at_least("x", 0, 0, 0.92)[3], False)


if __name__ == "__main__":
    unittest.main()
