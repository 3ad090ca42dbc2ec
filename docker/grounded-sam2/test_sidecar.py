"""The protocol layer with a model that finds a square: forms, refusals, masks. Needs fastapi, httpx, numpy, pillow.

    cd docker/grounded-sam2 && python -m unittest test_sidecar
"""

import io
import json
import unittest

import numpy as np
from fastapi.testclient import TestClient
from PIL import Image

from coco import compressed
from sidecar import Detection, app


def png(width=4, height=4, mode="RGB") -> bytes:
    file = io.BytesIO()
    Image.new(mode, (width, height), 128).save(file, "PNG")
    return file.getvalue()


def square(height=4, width=4):
    mask = np.zeros((height, width), bool)
    mask[1:3, 1:3] = True
    return mask


class FakeModel:
    """Finds a mug in the center, something with word pieces, and something that shows nowhere."""

    def __init__(self):
        self.asked = []

    def find(self, image, labels, box_threshold, text_threshold):
        self.asked.append((image.size, image.mode, labels, box_threshold, text_threshold))
        mask = square(image.size[1], image.size[0])
        return [
            Detection("##fying glass", 0.5, (0, 0, 2, 2), mask),
            Detection("mug", 0.93, (1, 1, 3, 3), mask),
            Detection("ghost", 0.99, (0, 0, 1, 1), np.zeros_like(mask)),
        ]


class Sidecar(unittest.TestCase):
    def setUp(self):
        self.model = FakeModel()
        self.client = TestClient(app(self.model.find))

    def asked(self, image=None, client=None, headers=None, request=None, **changed):
        question = {"labels": ["mug"], "box_threshold": 0.35, "text_threshold": 0.25} | changed
        files = {"image": ("image.png", png() if image is None else image, "image/png")}
        data = {"request": json.dumps(question) if request is None else request}
        return (client or self.client).post("/v1/segment", files=files, data=data, headers=headers)

    def test_the_documented_answer(self):
        answer = self.asked()
        self.assertEqual(answer.status_code, 200, answer.text)
        surest, other = answer.json()["annotations"]
        mask = {"size": [4, 4], "counts": "52203"}
        self.assertEqual(surest, {"class_name": "mug", "score": 0.93, "bbox": [1, 1, 3, 3], "segmentation": mask})
        self.assertEqual(other["class_name"], "##fying glass")
        self.assertEqual([answer.json()[name] for name in ("img_width", "img_height")], [4, 4])
        self.assertEqual(self.model.asked, [((4, 4), "RGB", ["mug"], 0.35, 0.25)])

    def test_images_are_wide_or_high_and_transparent_ones_lose_that(self):
        answer = self.asked(image=png(7, 5, "LA")).json()
        self.assertEqual((answer["img_width"], answer["img_height"]), (7, 5))
        self.assertEqual(answer["annotations"][0]["segmentation"]["size"], [5, 7])
        self.assertEqual(self.model.asked[0][:2], ((7, 5), "RGB"))

    def test_what_is_no_question_is_refused_with_a_reason(self):
        for changed in (
            {"labels": []},
            {"labels": "mug"},
            {"labels": ["Mug"]},
            {"labels": ["a.b"]},
            {"labels": [1]},
            {"labels": ["mug"] * 129},
            {"box_threshold": 1.5},
            {"box_threshold": True},
            {"text_threshold": "high"},
            {"request": "no JSON"},
            {"request": "[]"},
            {"image": b"GIF89a"},
            {"image": png()[:40]},
            {"image": b""},
        ):
            answer = self.asked(**changed)
            self.assertEqual(answer.status_code, 422, f"{changed}: {answer.text}")
            self.assertIsInstance(answer.json()["detail"], str, changed)
        self.assertEqual(self.model.asked, [])

    def test_large_images_are_refused_before_they_are_decoded(self):
        answer = self.asked(image=png(5000, 3, "1"))
        self.assertEqual(answer.status_code, 422)
        self.assertIn("5000 x 3", answer.json()["detail"])

    def test_a_key_is_wanted_where_there_is_one(self):
        client = TestClient(app(self.model.find, key="k-1"))
        self.assertEqual(self.asked(client=client).status_code, 401)
        self.assertEqual(self.asked(client=client, headers={"authorization": "Bearer k-2"}).status_code, 401)
        self.assertEqual(self.asked(client=client, headers={"authorization": "Bearer k-1"}).status_code, 200)
        self.assertEqual(client.get("/healthz").status_code, 200)

    def test_a_model_that_dies_is_an_error_of_the_server(self):
        def find(*_):
            raise RuntimeError("CUDA out of memory")

        client = TestClient(app(find), raise_server_exceptions=False)
        self.assertEqual(self.asked(client=client).status_code, 500)


class RunLengths(unittest.TestCase):
    def test_masks_come_back(self):
        draw = np.random.default_rng(1)
        masks = [square(), np.zeros((3, 5), bool), np.ones((3, 5), bool), ~square(6, 300)]
        masks += [draw.random((int(h), int(w))) < p for h, w, p in zip(draw.integers(1, 60, 40), draw.integers(1, 60, 40), draw.random(40))]
        for mask in masks:
            np.testing.assert_array_equal(decompressed(compressed(mask)), mask)


def decompressed(found: dict) -> np.ndarray:
    """After the description of the format, and of nothing in coco.py."""
    runs, number, shift = [], 0, 0
    for letter in found["counts"]:
        group = ord(letter) - 48
        number |= (group & 31) << shift
        shift += 5
        if not group & 32:
            if group & 16:
                number -= 1 << shift
            runs.append(number + (runs[-2] if len(runs) > 2 else 0))
            number, shift = 0, 0
    height, width = found["size"]
    flat = np.concatenate([np.full(run, k % 2 == 1) for k, run in enumerate(runs)])
    assert len(flat) == height * width
    return flat.reshape((height, width), order="F")


if __name__ == "__main__":
    unittest.main()
