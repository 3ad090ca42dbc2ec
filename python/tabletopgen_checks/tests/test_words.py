"""The tables of tests/words, the generated sentences, and the outcomes of names, sentences and instructions."""

import sys
import tempfile
import unittest
from pathlib import Path

from tabletopgen_checks.language import words
from tabletopgen_checks.language.generated_sentences import MAX_OBJECTS, generated
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.tests.test_expectations import entity, predicate, span

RELATIONS = set(
    "on in left_of right_of in_front_of behind next_to between facing parallel_to around stacked_on at_center at_back "
    "at_front at_left at_right at_back_left at_back_right at_front_left at_front_right from_left_edge from_right_edge "
    "from_front_edge from_back_edge distance".split()
)
PREDICATES = set(
    "in out_of on off stacked_on left_of right_of in_front_of behind next_to between away_from at_center at_back at_front "
    "at_left at_right at_back_left at_back_right at_front_left at_front_right swapped lifted opened closed upright "
    "lying_on_side upside_down rotated moved poured_into used_on pressed".split()
)
REASONS = set(
    "unknown_object unknown_word not_placeable out_of_range not_supported contradiction no_referent "
    "not_expressible".split()
)
ARRANGEMENTS = {"row", "column", "circle", "grid", "pile", "pyramid", "stack"}
KEYS = {"id", "kind", "text", "objects", "absent", "closed", "relations", "arrangements", "any_of", "table", "goal",
        "reported", "refused", "message", "corrected", "fillings"}


def described(*objects, **more):
    return {"description": {"table": {}, "objects": list(objects), **more}}


def error(message):
    return {"error": {"code": "nothing_recognized", "message": message, "terms": []}}


def all_of(name, *places):
    """Every value of a key, of which several may stand in a list."""
    for place in places:
        yield from place[name] if isinstance(place.get(name), list) else [place[name]] if name in place else []


class Tables(unittest.TestCase):
    def test_sizes(self):
        self.assertEqual(len(words.names()), 460)
        self.assertEqual(len(words.entries("sentences")), 300)
        self.assertEqual(len(words.entries("tasks")), 200)

    def test_entries_use_the_names_of_the_format(self):
        for entry in words.entries("sentences") + words.entries("tasks") + [s.expectation for s in generated(200)]:
            with self.subTest(entry["id"]):
                self.assertLessEqual(entry.keys(), KEYS)
                alternatives = [one for options in entry.get("any_of", ()) for one in options]
                relations = entry.get("relations", []) + [one["relation"] for one in alternatives if "relation" in one]
                groups = entry.get("arrangements", [])
                groups = groups + [one["arrangement"] for one in alternatives if "arrangement" in one]
                self.assertLessEqual(set(all_of("relation", *relations)), RELATIONS)
                self.assertLessEqual(set(all_of("kind", *groups)), ARRANGEMENTS)
                self.assertLessEqual(set(all_of("predicate", *entry.get("goal", ()))), PREDICATES)
                self.assertLessEqual(set(all_of("reason", *entry.get("reported", ()))), REASONS)

    def test_references_mean_an_object_of_the_entry(self):
        for entry in words.entries("sentences") + words.entries("tasks"):
            cast = words.Cast(entry["objects"], [])
            # An object for every entry, so that a reference to none is seen.
            cast.taken = [[k] for k in range(len(entry["objects"]))]
            for place in entry.get("relations", []) + entry.get("goal", []):
                for key in ("object", "target", "second"):
                    if key in place:
                        self.assertTrue(cast.of(place[key]), f"{entry['id']}: {place[key]}")

    def test_every_kind_has_ten_and_no_text_stands_twice(self):
        for table in ("sentences", "tasks"):
            every = words.entries(table)
            for key in ("id", "text"):
                self.assertEqual(len({entry[key] for entry in every}), len(every))
        kinds = [entry["kind"] for entry in words.entries("sentences")]
        self.assertGreaterEqual(min(map(kinds.count, set(kinds))), 10)

    def test_names_say_what_is_expected(self):
        for name in words.names():
            exact, sensible = bool(name.exact), bool(name.sensible)
            says = {"exact": exact, "stand_in": sensible and not exact, "refuse": not exact}
            self.assertTrue(says[name.expected], name.name)


class Generated(unittest.TestCase):
    def test_sentences_count_what_they_name(self):
        every = generated(300)
        self.assertEqual({s.objects for s in every}, set(range(1, MAX_OBJECTS + 1)))
        for one in every:
            self.assertEqual(sum(entry["count"] for entry in one.expectation["objects"]), one.objects)
            names = [entry["category"] for entry in one.expectation["objects"]]
            self.assertEqual(len(set(names)), len(names), one.text)

    def test_the_set_does_not_depend_on_how_many_are_asked_for(self):
        self.assertEqual([s.text for s in generated(20)], [s.text for s in generated(50)][:20])
        self.assertGreater(len({s.text for s in generated(300)}), 290)


class Names(unittest.TestCase):
    def outcome(self, name, outcome):
        return words.outcome_of(name, outcome, {"a", "an", "with", "table"})[0]

    def test_outcomes(self):
        can = words.Name("hope", "corn can", "exact", ["food_can"], ["soda_can"])
        account = {"understood": [{"span": span("corn can", 15), "kind": "object"}]}
        for objects, expected in [
            ([entity("food_can_1")], "exact"),
            ([entity("food_can_1"), entity("food_can_2")], "exact"),
            ([entity("jar_1", stand_in=True)], "stand-in"),
            ([entity("food_can_1", stand_in=True)], "stand-in"),
            ([entity("soda_can_1")], "unmarked"),
            ([entity("corn_1")], "wrong"),
            ([entity("food_can_1"), entity("corn_1")], "wrong"),
            ([entity("food_can_1"), entity("corn_1", requested=False)], "exact"),
            ([], "silent"),
        ]:
            self.assertEqual(self.outcome(can, described(*objects, **account)), expected, objects)

    def test_words_without_account_are_silent(self):
        can = words.Name("hope", "corn can", "exact", ["food_can"], [])
        account = {"understood": [{"span": span("can", 20), "kind": "object"}]}
        found = words.outcome_of(can, described(entity("food_can_1"), **account), {"a", "with", "table"})
        self.assertEqual(found[2], ["corn"])

    def test_refusals_are_right_where_they_are_expected(self):
        socket = words.Name("maniskill", "wall socket", "refuse", [], [])
        cube = words.Name("maniskill", "cube", "exact", ["cube"], [])
        self.assertEqual(self.outcome(socket, error("not known")), "exact")
        self.assertEqual(self.outcome(cube, error("not known")), "refused")
        report = {"unrecognized": [{"span": span("cube", 15), "reason": "unknown_object"}]}
        self.assertEqual(self.outcome(cube, described(**report)), "refused")


class Sentences(unittest.TestCase):
    def test_refused_texts(self):
        entry = {"objects": [], "refused": True, "message": "English"}
        self.assertEqual(words.sentence_complaints(entry, error("write the text in English")), [])
        self.assertIn("does not say English", words.sentence_complaints(entry, error("nothing known"))[0])
        self.assertEqual(words.sentence_complaints(entry, described(entity("mug_1"))), ["not refused, but 1 mug"])

    def test_refused_texts_that_should_not_be(self):
        mug = {"objects": [{"category": "mug", "count": 1}]}
        self.assertEqual(words.sentence_complaints(mug, error("no")), ["refused: no"])
        maybe = {"objects": [{"category": "mug", "count": [0, 2]}], "reported": [{"text": "mugs"}]}
        self.assertEqual(words.sentence_complaints(maybe, error("no")), [])

    def test_goals_of_sentences_count(self):
        entry = {"objects": [{"category": "mug", "count": 1}], "goal": [{"predicate": "lifted", "object": "mug"}]}
        goal = {"instruction": "", "predicates": [predicate("lifted", "mug_1")]}
        self.assertEqual(words.sentence_complaints(entry, described(entity("mug_1"), goal=goal)), [])
        found = words.sentence_complaints(entry, described(entity("mug_1")))
        self.assertEqual(found, ["goal lifted mug: stated for 0 of 1"])


class Tasks(unittest.TestCase):
    ENTRY = {"objects": [{"category": "apple", "count": 1}, {"category": "bowl", "count": 1}],
             "goal": [{"predicate": "in", "object": "apple", "target": "bowl"}]}
    GOAL = {"instruction": "", "predicates": [predicate("in", "apple_1", "bowl_1")]}

    def test_right_start_and_goal(self):
        score = words.task_score(self.ENTRY, described(entity("apple_1"), entity("bowl_1"), goal=self.GOAL))
        self.assertEqual((score.scene, score.goal, score.solved), ([], [], False))

    def test_solved_start(self):
        start = described(entity("apple_1", ("in", "bowl_1")), entity("bowl_1"), goal=self.GOAL)
        self.assertTrue(words.task_score(self.ENTRY, start).solved)

    def test_no_goal_and_no_scene(self):
        score = words.task_score(self.ENTRY, described(entity("apple_1"), entity("bowl_1")))
        self.assertTrue(score.solved and score.goal)
        score = words.task_score(self.ENTRY, error("no"))
        self.assertTrue(score.solved and score.goal and score.scene)


class Parse(unittest.TestCase):
    def lab(self, folder, body) -> Path:
        path = Path(folder) / "lab"
        path.write_text(f"#!{sys.executable}\nimport json, sys\n{body}", encoding="utf-8")
        path.chmod(0o755)
        return path

    def test_every_text_gets_its_answer(self):
        with tempfile.TemporaryDirectory() as folder:
            lab = self.lab(folder, "for line in open(sys.argv[3]): print(json.dumps({'said': json.loads(line)}))")
            self.assertEqual(words.parse(lab, ["a mug", "two\nlines"]), [{"said": "a mug"}, {"said": "two\nlines"}])

    def test_missing_answers_are_a_problem(self):
        with tempfile.TemporaryDirectory() as folder:
            lab = self.lab(folder, "print(json.dumps({}))")
            with self.assertRaisesRegex(Problem, "gave 1 answers"):
                words.parse(lab, ["a mug", "a plate"])
            with self.assertRaisesRegex(Problem, "does not start"):
                words.parse(Path(folder) / "none", ["a mug"])


class Sample(unittest.TestCase):
    def test_samples_are_spread_and_fixed(self):
        self.assertEqual(words.sample(list(range(100)), 4), [0, 25, 50, 75])
        self.assertEqual(words.sample([1, 2], 4), [1, 2])
        kinds = {entry["kind"] for entry in words.sample(words.entries("sentences"), 40)}
        self.assertEqual(kinds, {entry["kind"] for entry in words.entries("sentences")})


if __name__ == "__main__":
    unittest.main()
