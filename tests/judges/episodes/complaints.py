"""What a judge found: complaints, counts of checks, and the largest error of decoded images."""

import numpy as np

# H.264 at 4:2:0 smears colors at edges, and leaves traces of the square where it was. Measured: rms 5.0, flat regions
# 10. By calculation the next frame instead of the right one, whose square is two pixels further, has an rms of 9.6.
MAX_RMS, MAX_FLAT_ERROR = 8.0, 14


class Complaints:
    def __init__(self):
        self.texts, self.checks, self.worst_rms, self.worst_flat = [], 0, 0.0, 0

    def equal(self, name: str, actual, expected) -> None:
        self.checks += 1
        if isinstance(expected, np.ndarray):
            actual = np.asarray(actual)
            same = actual.shape == expected.shape and np.array_equal(actual, expected)
        else:
            same = actual == expected
        if not same and len(self.texts) < 20:
            self.texts.append(f"{name}: {short(actual)}, not {short(expected)}")

    def close(self, name: str, actual, expected, tolerance: float) -> None:
        self.checks += 1
        actual, expected = np.asarray(actual, float), np.asarray(expected, float)
        if actual.shape != expected.shape or np.abs(actual - expected).max() > tolerance:
            self.texts.append(f"{name}: {short(actual)}, not {short(expected)} within {tolerance}")

    def image(self, name: str, actual: np.ndarray, expected: np.ndarray, is_exact: bool) -> None:
        """Compares row x column x RGB, 0 to 255; exactly, or within the error of the codec."""
        if is_exact:
            self.equal(name, actual, expected)
            return
        self.checks += 1
        if actual.shape != expected.shape:
            self.texts.append(f"{name}: shape {actual.shape}, not {expected.shape}")
            return
        error = np.abs(actual.astype(int) - expected.astype(int))
        rms, flat = float(np.sqrt((error.astype(float) ** 2).mean())), int(error[flat_regions(expected)].max())
        self.worst_rms, self.worst_flat = max(self.worst_rms, rms), max(self.worst_flat, flat)
        if (rms > MAX_RMS or flat > MAX_FLAT_ERROR) and len(self.texts) < 20:
            self.texts.append(f"{name}: rms {rms:.1f}, flat regions {flat}")

    def facts(self) -> dict:
        facts = {"checks": self.checks}
        if self.worst_rms:
            facts.update(worst_rms=round(self.worst_rms, 2), worst_flat_error=self.worst_flat)
        return facts


def flat_regions(image: np.ndarray) -> np.ndarray:
    """Pixels whose neighbors within four pixels have their color."""
    flat = np.ones(image.shape[:2], bool)
    for shift in range(1, 5):
        for axis in (0, 1):
            for sign in (1, -1):
                flat &= (np.roll(image, sign * shift, axis) == image).all(2)
    flat[:4], flat[-4:], flat[:, :4], flat[:, -4:] = False, False, False, False
    return flat


def short(value) -> str:
    text = str(value).replace("\n", " ")
    return text if len(text) < 120 else text[:120] + "..."
