"""The stand-ins of a WordNet of a dozen nouns."""

import tempfile
import unittest
from pathlib import Path

from tabletopgen_checks.language import stand_ins
from tabletopgen_checks.language.wordnet import Nouns

# Offset: words, offsets of hypernyms (with @i: of an instance). The words' senses are in the order of the offsets.
SYNSETS = {
    10: ("entity", ""),
    20: ("object", "10"),
    25: ("plant", "20"),
    30: ("vessel", "20"),
    40: ("mug", "30"),
    50: ("amount", "10"),
    60: ("mug goblet", "50"),
    65: ("goblet", "30"),
    70: ("vehicle", "20"),
    80: ("cart", "70 30"),
    85: ("oak_tree", "25"),
    90: ("Ghent", "30@i"),
    95: ("lily", "25"),
    96: ("lily pond_lily", "30"),
    93: ("fern", "25"),
    94: ("tree_fern", "93"),
    98: ("crew", "50"),
    99: ("crew", "30"),
}
COUNTS = {("mug", 1): 9, ("crew", 1): 30, ("crew", 2): 4}
RULES = {
    "shape": [
        {"name": "cup", "of": ["vessel.n.01", "goblet.n.02"]},
        {"name": "flower", "of": ["lily.n.01", "fern.n.01"]},
    ],
    "refusal": [
        {"reason": "too_large", "of": ["vehicle.n.01", "plant.n.01"]},
        {"reason": "abstract", "of": ["entity.n.01"]},
    ],
    "meanings": {"beaker": "mug.n.01"},
    "categories": {},
    "ignored": {"of": []},
    "plants": {"of": ["plant.n.01"]},
    "living": {"of": ["plant.n.01"]},
    "too_general": {"of": ["entity.n.01", "object.n.01"]},
    "left_out": {"nouns": ["amount"]},
}
# A comment like WordNet's license, which is indented.
LICENSE = "  1 This software and database is being provided to you\n"


def written(folder: Path):
    """The three files of WordNet that the script reads."""
    data, senses = [], {}
    for offset, (words, above) in SYNSETS.items():
        spelled = words.split()
        pointers = [(word.removesuffix("@i"), "@i" if word.endswith("@i") else "@") for word in above.split()]
        fields = [f"{offset:08d}", "06", "n", f"{len(spelled):02x}", *(f"{word} 0" for word in spelled)]
        fields += [f"{len(pointers):03d}", *(f"{symbol} {int(up):08d} n 0000" for up, symbol in pointers)]
        data.append(" ".join(fields) + " | what it is  \n")
        for word in spelled:
            senses.setdefault(word.lower(), []).append(f"{offset:08d}")
    index = [f"{w} n {len(found)} 1 @ {len(found)} 0 {' '.join(found)}  \n" for w, found in senses.items()]
    counts = [f"{word}%1:06:00:: {sense} {count}\n" for (word, sense), count in COUNTS.items()]
    for name, lines in [("data.noun", [LICENSE, *data]), ("index.noun", [LICENSE, *index]), ("cntlist.rev", counts)]:
        (folder / name).write_text("".join(lines), encoding="latin-1")


class OfSmallWordNet(unittest.TestCase):
    def setUp(self):
        with tempfile.TemporaryDirectory() as folder:
            written(Path(folder))
            self.nouns = Nouns(Path(folder))
        self.rules = stand_ins.Rules(RULES, self.nouns)
        files = [{"category": [{"name": "mug", "label": "mug"}, {"name": "tea_mug", "label": "tea mug"}]}]
        self.categories = stand_ins.Categories(files, self.rules, {})
        self.rows = stand_ins.table(self.rules, self.categories)
        self.of = {noun: (key, near) for (_, key, near), nouns in self.rows.items() for noun in nouns}

    def test_synsets_are_named_by_word_and_sense(self):
        self.assertEqual(self.nouns.synset("mug.n.02"), 60)
        for name in ("mug.n.03", "nothing.n.01", "mug"):
            with self.assertRaisesRegex(ValueError, "no noun sense of WordNet"):
                self.nouns.synset(name)

    def test_levels_hold_each_meaning_once_at_its_smallest_distance(self):
        self.assertEqual(self.nouns.levels(80), ({80}, {70, 30}, {20}, {10}))

    def test_the_meaning_of_highest_frequency_counts(self):
        self.assertEqual(self.of["mug"], ("cup", "mug"))

    def test_among_equally_frequent_meanings_an_object_comes_first_and_a_plant_last(self):
        self.assertEqual(self.of["goblet"][0], "cup")
        self.assertEqual(self.of["lily"][0], "cup")

    def test_a_second_meaning_counts_unless_the_first_is_much_more_frequent(self):
        self.assertEqual(self.of["crew"][0], "not:abstract")
        self.nouns.counts["crew", 1] = 20
        found = self.rules.meaning("crew")
        assert found is not None
        self.assertEqual(found.rule.key, "cup")

    def test_the_first_of_equally_near_rules_counts(self):
        self.assertEqual(self.of["cart"][0], "cup")

    def test_names_species_and_left_out_nouns_are_not_listed(self):
        self.assertEqual({"ghent", "amount", "tree fern"} & self.of.keys(), set())
        self.assertEqual((self.of["fern"][0], self.of["oak tree"][0]), ("flower", "not:too_large"))

    def test_added_nouns_follow_their_meaning(self):
        self.assertEqual(self.of["beaker"], ("cup", "mug"))

    def test_the_nearest_category_shares_a_specific_meaning(self):
        self.assertEqual(self.of["goblet"][1], "mug")
        self.assertEqual(self.categories.nearest(70), stand_ins.NO_CATEGORY)

    def test_rows_are_short_and_keep_every_noun(self):
        rows = {(0, "cup", "mug"): [f"vessel {chr(97 + k)}" for k in range(26)]}
        lines = stand_ins.written(rows).splitlines()[stand_ins.HEADER.count("\n") :]
        self.assertTrue(len(lines) > 1 and all(len(line) <= stand_ins.WIDTH for line in lines))
        self.assertEqual(";".join(line.split("\t")[2] for line in lines).split(";"), rows[0, "cup", "mug"])

    def test_a_meaning_of_two_rules_is_an_error(self):
        twice = {**RULES, "refusal": [{"reason": "abstract", "of": ["vessel.n.01"]}]}
        with self.assertRaisesRegex(ValueError, "keep one of them"):
            stand_ins.Rules(twice, self.nouns)


class OfTheRepository(unittest.TestCase):
    def test_the_header_names_the_license(self):
        text = stand_ins.RESULT.read_text(encoding="utf-8")
        self.assertTrue(text.startswith(stand_ins.HEADER))
        self.assertTrue((stand_ins.CATALOG / "stand_ins.LICENSE").is_file())


if __name__ == "__main__":
    unittest.main()
