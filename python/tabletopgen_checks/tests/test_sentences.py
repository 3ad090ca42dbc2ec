"""What a scene is compared with its sentence for: counts, the table, places and stacks."""

import unittest

from tabletopgen_checks.language.sentences import Sentence, sentence
from tabletopgen_checks.tests.made_up_scenes import body, scene

ASKED = {
    "objects": [{"category": "mug", "count": 1}, {"category": "plate", "count": 2}],
    "relations": [{"relation": "left_of", "object": "mug", "target": "plate"}],
    "arrangements": [{"kind": "stack", "category": "plate", "count": 2}],
    "table": {"shape": "rectangular"},
}
PLATE, UPPER = body("plate_1", 0.2, 0.0), body("plate_2", 0.2, 0.0, 0.1, parent="plate_1")
MUG = body("mug_1", -0.2, 0.0)


class Sentences(unittest.TestCase):
    def complaints(self, *bodies, **more):
        return Sentence("desk", 1, "A desk", ASKED).complaints(scene(*bodies, **more))

    def test_a_scene_as_asked_for_has_none(self):
        self.assertEqual(self.complaints(MUG, PLATE, UPPER), [])

    def test_too_little_and_too_much_are_complaints(self):
        self.assertIn("1 plate instead of 2", self.complaints(MUG, PLATE))
        self.assertEqual(self.complaints(MUG, PLATE, UPPER, body("fork_1", 0.0, 0.2)), ["fork_1 is not asked for"])

    def test_another_place_and_a_stack_that_is_none_are_complaints(self):
        self.assertEqual(self.complaints(body("mug_1", 0.4, 0.0), PLATE, UPPER), ["mug left_of plate: holds for 0 of 1"])
        self.assertEqual(self.complaints(MUG, PLATE, body("plate_2", 0.4, 0.2)), ["no stack of plate"])

    def test_another_table_is_a_complaint(self):
        self.assertEqual(self.complaints(MUG, PLATE, UPPER, shape="round"), ["a round table instead of a rectangular one"])

    def test_counts_of_a_table_of_sentences_are_expectations(self):
        asked = sentence("pair", 7, "Two mugs", {"mug": 2}, "round", sample=True)
        self.assertEqual(asked.expectation, {"objects": [{"category": "mug", "count": 2}], "table": {"shape": "round"}})
        self.assertEqual((asked.objects, asked.sample, asked.threads), (2, True, False))


if __name__ == "__main__":
    unittest.main()
