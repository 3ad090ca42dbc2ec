"""python -m unittest discover training: squares are cut as the program cuts them, and scores count what they say."""

import unittest

import numpy as np
import torch
from PIL import Image

from close_ups import GRAY, cut_out, square, varied
from encoder import INPUT_PX, Encoder, as_read, normalized, public_weights
from recognizer import first_classifier, fitting_temperature, scores


class Squares(unittest.TestCase):
    def test_square_moves_into_the_image_and_repeats_its_edge(self):
        image = Image.fromarray(np.arange(40 * 60 * 3, dtype=np.uint32).reshape(40, 60, 3).astype(np.uint8))
        inside = square(image, (50, 10, 58, 30), 0.1)
        self.assertEqual(inside.size, (24, 24))
        self.assertTrue(np.array_equal(np.asarray(inside), np.asarray(image)[8:32, 36:60]))
        larger = np.asarray(square(image, (5, 0, 55, 40), 0.0))
        self.assertEqual(larger.shape, (50, 50, 3))
        self.assertTrue(np.array_equal(larger[0], larger[5]) and np.array_equal(larger[45], larger[44]))

    def test_surroundings_become_gray(self):
        mask = np.zeros((30, 30), np.uint8)
        mask[10:20, 10:20] = 255
        image = Image.fromarray(np.full((30, 30, 3), 200, np.uint8))
        for growth, own in ((1, 100), (5, 196)):
            cut = np.asarray(cut_out(image, Image.fromarray(mask), growth))
            self.assertEqual(((cut == 200).all(2).sum(), (cut == GRAY).all(2).sum()), (own, 900 - own))

    def test_variation_follows_its_random_stream(self):
        import random

        image = Image.fromarray(np.random.default_rng(1).integers(0, 256, (50, 50, 3), dtype=np.uint8))
        mask = Image.fromarray(np.full((50, 50), 255, np.uint8))
        first, again, other = (varied(image, mask, (10, 10, 40, 40), random.Random(seed)) for seed in (3, 3, 4))
        self.assertEqual(first.shape, (INPUT_PX, INPUT_PX, 3))
        self.assertTrue(np.array_equal(first, again) and not np.array_equal(first, other))


class Recognizer(unittest.TestCase):
    def test_encoder_agrees_with_its_parts_and_names_its_tensors(self):
        encoder = Encoder(public_weights()).eval()
        x = normalized(np.random.default_rng(2).integers(0, 256, (1, 64, 64, 3), dtype=np.uint8))
        with torch.no_grad():
            features = encoder(x)
            self.assertTrue(torch.equal(features, encoder.learning(encoder.frozen(x))))
        self.assertEqual(features.shape, (1, 1280))
        weight, bias = first_classifier(encoder, ["mug", "washer"])
        self.assertTrue(weight[0].abs().sum() > 0 and not weight[1].any() and not weight[2].any())
        tensors = as_read(encoder, weight, bias, ["mug", "washer", "unknown"])
        self.assertEqual(bytes(tensors["categories"].tolist()), b"mug\nwasher\nunknown")
        self.assertEqual(tensors["blocks.20.depthwise.weight"].shape, (1248, 3, 3))

    def test_scores_count(self):
        # Four classes and unknown: right and sure, right and unsure, wrong and sure, of no category, withheld.
        values = torch.log(torch.tensor([
            [0.9, 0.1, 0, 0, 0], [0.4, 0.3, 0.2, 0.1, 0], [0.9, 0.1, 0, 0, 0], [0.1, 0, 0, 0, 0.9], [0.6, 0.4, 0, 0, 0],
        ]) + 1e-9)
        found = scores(values, torch.tensor([0, 0, 1, 4, 2]), 4, torch.tensor([False] * 4 + [True]))
        self.assertEqual((found["first"], found["named"], found["right_of_named"]), (0.6667, 0.6667, 0.5))
        self.assertEqual((found["no_category_unnamed"], found["withheld_unnamed"]), (1.0, 0.0))
        self.assertEqual((found["tenths"][8], found["tenths"][9], found["tenths"][4]), ([0, None], [2, 0.5], [1, 1.0]))

    def test_temperature_flattens_what_is_too_sure(self):
        labels = torch.arange(400) % 4
        values = 4.0 * torch.nn.functional.one_hot(torch.where(torch.arange(400) % 3 == 0, (labels + 1) % 4, labels), 4)
        self.assertGreater(fitting_temperature(values.float(), labels), 1.5)


if __name__ == "__main__":
    unittest.main()
