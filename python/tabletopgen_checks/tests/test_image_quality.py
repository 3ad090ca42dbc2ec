"""The bar of images beside those of the path tracer."""

import struct
import tempfile
import unittest
import zlib
from pathlib import Path

from tabletopgen_checks.bars.image_quality import LINEAR, Difference, Pixels, difference, page, pixels, ssim


def even(level: int) -> Pixels:
    return Pixels(16, [bytes([level, level, level, 255]) * 16] * 12)


def png(rows: list, color_type: int) -> bytes:
    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    channels = {2: 3, 6: 4}[color_type]
    head = struct.pack(">IIBBBBB", len(rows[0]) // channels, len(rows), 8, color_type, 0, 0, 0)
    packed = zlib.compress(b"".join(b"\x00" + row for row in rows))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")


class ImageQuality(unittest.TestCase):
    def test_bias_has_the_sign_of_what_is_too_light(self):
        found = difference(even(200), even(100), 1.0)
        self.assertAlmostEqual(found.bias, LINEAR[200] - LINEAR[100])
        self.assertAlmostEqual(found.error, abs(found.bias))
        self.assertLess(difference(even(100), even(200), 1.0).bias, 0.0)

    def test_equal_images_are_alike_and_inverted_ones_are_not(self):
        ramp = [[float(16 * x + y) for x in range(16)] for y in range(16)]
        self.assertAlmostEqual(ssim(ramp, ramp), 1.0)
        self.assertLess(ssim(ramp, [[255.0 - value for value in row] for row in ramp]), 0.2)

    def test_images_with_and_without_alpha_are_read(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "one.png"
            for color_type, row in ((2, bytes([1, 2, 3, 4, 5, 6])), (6, bytes([1, 2, 3, 9, 4, 5, 6, 9]))):
                path.write_bytes(png([row, row], color_type))
                self.assertEqual(pixels(path).channels(), [b"\x01\x04" * 2, b"\x02\x05" * 2, b"\x03\x06" * 2])

    def test_a_bar_holds_where_high_is_near_and_no_farther_than_fast(self):
        near, far = Difference(0.01, 0.0, 0.95, 1.0), Difference(0.2, 0.1, 0.5, 1.0)
        for fast, high, expected in ((far, near, True), (near, far, False), (far, far, False)):
            body, holds = page({"A mug": {"fast": fast, "high": high, "reference": 90.0}}, 480, 256)
            self.assertEqual(holds, expected)
            self.assertIn("| A mug |", body)


if __name__ == "__main__":
    unittest.main()
