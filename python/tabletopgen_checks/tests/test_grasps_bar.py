"""The bar of grasps: which categories count, and which are named."""

import unittest

from tabletopgen_checks.bars.grasps import category_summary


def tried(category, candidates=3, stable_slip_m=None, unstable_slip_m=None):
    return {
        "category": category, "mass_kg": 0.1, "thinnest_m": 0.02, "candidates": candidates, "tried": candidates,
        "stable_slip_m": stable_slip_m, "unstable_slip_m": unstable_slip_m,
    }


class Categories(unittest.TestCase):
    def test_categories_that_do_not_fit_do_not_count(self):
        outcomes = [tried("mug", stable_slip_m=0.0004), tried("melon", candidates=0)]
        bars, text = category_summary({"panda": outcomes})
        self.assertEqual([(found, holds) for _, found, _, holds in bars], [("100.0 % of 1", True), ("0.40 mm", True)])
        self.assertIn("Panda: 2 categories for grippers, 1 fit; without a stable grasp: none.", text)

    def test_categories_without_a_stable_grasp_are_named_with_their_slip(self):
        outcomes = [tried("mug", stable_slip_m=0.0012), tried("ham", unstable_slip_m=0.0032), tried("book")]
        bars, text = category_summary({"panda": outcomes})
        self.assertEqual([holds for *_, holds in bars], [False, False])
        self.assertIn("ham (3.2 mm), book.", text)
        self.assertIn("| 33.3 % of 3 | 95 % | DOES NOT HOLD |", text)


if __name__ == "__main__":
    unittest.main()
