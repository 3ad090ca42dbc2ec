"""What is measured of a finished scene: for every relation and arrangement poses that hold it and poses that do not."""

import unittest

from tabletopgen_checks.language.description import Described
from tabletopgen_checks.language.measured import Measured
from tabletopgen_checks.tests.made_up_scenes import body
from tabletopgen_checks.tests.made_up_scenes import scene as made_up


def scene(*bodies):
    objects = [
        {"id": b["name"], "label": b["category"], "category": b["category"], "size_m": b["size_m"], "requested": True,
         "relations": []}
        for b in bodies
    ]
    described = Described({"table": {}, "objects": objects})
    return Measured(made_up(*bodies), described)


A, B = "mug_1", "plate_1"
WIDE = (0.3, 0.05, 0.02)

# (relation, right, wrong); of the first body to the second, and the third.
RELATIONS = [
    ("left_of", [body(A, -0.3, 0), body(B, 0.3, 0)], [body(A, 0.3, 0), body(B, -0.3, 0)]),
    ("right_of", [body(A, 0.3, 0), body(B, 0, 0)], [body(A, 0, 0.2), body(B, 0, -0.2)]),
    ("in_front_of", [body(A, 0, -0.2), body(B, 0, 0.1)], [body(A, 0, 0.1), body(B, 0, -0.2)]),
    ("behind", [body(A, 0, 0.2), body(B, 0, 0)], [body(A, 0, -0.2), body(B, 0, 0)]),
    ("next_to", [body(A, 0.15, 0), body(B, 0, 0)], [body(A, 0.5, 0), body(B, -0.4, 0)]),
    ("on", [body(A, 0, 0, 0.1, parent=B), body(B, 0, 0)], [body(A, 0.3, 0), body(B, 0, 0)]),
    ("stacked_on", [body(A, 0, 0, 0.1, parent=B), body(B, 0, 0)], [body(A, 0.3, 0), body(B, 0, 0)]),
    ("in", [body(A, 0, 0, 0.01, (0.03, 0.03, 0.05), parent=B), body(B, 0, 0)], [body(A, 0.3, 0), body(B, 0, 0)]),
    ("facing", [body(A, 0, 0.2), body(B, 0, -0.2)], [body(A, 0, 0.2, yaw_deg=90), body(B, 0, -0.2)]),
    ("parallel_to", [body(A, 0, 0, size=WIDE, yaw_deg=175), body(B, 0, 0.2, size=WIDE)],
     [body(A, 0, 0, size=WIDE, yaw_deg=60), body(B, 0, 0.2, size=WIDE)]),
    ("around", [body(A, 0.2, 0.1), body(B, 0, 0)], [body(A, 0.5, 0.2), body(B, -0.5, -0.2)]),
    ("at_center", [body(A, 0.05, 0.02), body(B, 0, 0.2)], [body(A, 0.3, 0), body(B, 0, 0)]),
    ("at_left", [body(A, -0.4, 0), body(B, 0, 0)], [body(A, 0.4, 0), body(B, 0, 0)]),
    ("at_back_right", [body(A, 0.4, 0.2), body(B, 0, 0)], [body(A, 0.4, 0), body(B, 0, 0)]),
]


class Relations(unittest.TestCase):
    def test_relations_are_measured(self):
        for kind, right, wrong in RELATIONS:
            target = None if kind.startswith("at_") else B
            with self.subTest(kind):
                self.assertTrue(scene(*right).related(kind, A, target))
                self.assertFalse(scene(*wrong).related(kind, A, target))

    def test_the_left_of_a_seat_is_that_of_the_person_who_sits_there(self):
        for plate, fork, is_left in [
            ((0, 0.2), (0.2, 0.2), True), ((0, 0.2), (-0.2, 0.2), False), ((0.5, 0), (0.5, -0.2), True),
            ((0, -0.2), (-0.2, -0.2), True), ((-0.5, 0), (-0.5, 0.2), True),
        ]:
            with self.subTest(plate=plate, fork=fork):
                found = scene(body(A, *fork), body(B, *plate))
                found.described.seated.add((A, B))
                self.assertEqual(found.related("left_of", A, B), is_left)

    def test_between_is_on_the_way(self):
        ends = [body("jar_1", -0.3, 0), body("jar_2", 0.3, 0)]
        self.assertTrue(scene(body(A, 0.05, 0.05), *ends).related("between", A, "jar_1", "jar_2"))
        self.assertFalse(scene(body(A, 0.45, 0), *ends).related("between", A, "jar_1", "jar_2"))
        self.assertFalse(scene(body(A, 0, 0.25), *ends).related("between", A, "jar_1", "jar_2"))

    def test_what_stands_on_something_on_a_tray_is_on_the_tray(self):
        tray, plate = body(B, 0, 0, size=(0.4, 0.3, 0.02)), body("plate_2", 0.05, 0, 0.02, (0.1, 0.1, 0.1), parent=B)
        self.assertTrue(scene(body(A, 0.05, 0, 0.12, parent="plate_2"), plate, tray).related("on", A, B))
        self.assertFalse(scene(body(A, 0.35, 0, 0.12, parent="plate_2"), plate, tray).related("on", A, B))
        self.assertFalse(scene(body(A, 0.05, 0, 0.12, parent="table"), plate, tray).related("on", A, B))

    def test_distances_are_between_boxes_and_to_edges(self):
        found = scene(body(A, -0.2, 0), body(B, 0.1, 0))
        self.assertAlmostEqual(found.distances_cm("left_of", A, B)[0], 20.0)
        self.assertAlmostEqual(found.distances_cm("from_left_edge", A, None)[0], 35.0)
        self.assertAlmostEqual(found.distances_cm("from_back_edge", B, None)[0], 25.0)

    def test_poses_are_read_from_the_tilt(self):
        turned = body(A, 0, 0, yaw_deg=30)
        found = scene(turned, body(B, 0.3, 0, 0.05, tilt_deg=90), body("jar_1", -0.3, 0, 0.1, tilt_deg=180))
        self.assertEqual([item.pose for item in found.objects], ["upright", "lying_on_side", "upside_down"])
        self.assertAlmostEqual(found.objects[0].yaw_deg, 30.0)

    def test_missing_objects_are_listed(self):
        whole = scene(body(A, 0, 0), body(B, 0.3, 0))
        whole.bodies.pop(B)
        self.assertEqual(whole.differences(), ["plate_1 is not in the scene"])


def cups(*places, parents=None):
    return [body(f"cup_{k + 1}", *place, parent=(parents or {}).get(k + 1, "table")) for k, place in enumerate(places)]


# (kind, right, wrong)
ARRANGEMENTS = [
    ("row", cups((-0.2, 0), (0, 0.01), (0.2, 0)), cups((-0.2, 0), (0, 0.2), (0.2, -0.2))),
    ("column", cups((0, -0.2), (0.01, 0), (0, 0.2)), cups((-0.2, 0), (0, 0), (0.2, 0))),
    ("circle", cups((0.2, 0), (0, 0.2), (-0.2, 0), (0, -0.2)), cups((0.2, 0), (0.05, 0.2), (-0.2, 0), (0.3, 0.1))),
    ("grid", cups((0, 0), (0.2, 0), (0, 0.2), (0.2, 0.2)), cups((0, 0), (0.2, 0), (0.4, 0), (0.2, 0.2))),
    ("pile", cups((0, 0), (0.11, 0), (0.05, 0, 0.1)), cups((0, 0), (0.11, 0), (0.4, 0))),
    ("pyramid", cups((0, 0), (0.1, 0), (0.05, 0, 0.1)), cups((0, 0), (0.1, 0), (0.2, 0))),
    ("stack", cups((0, 0), (0, 0, 0.1), (0, 0, 0.2), parents={2: "cup_1", 3: "cup_2"}),
     cups((0, 0), (0, 0, 0.1), (0.3, 0), parents={2: "cup_1"})),
]


class Arrangements(unittest.TestCase):
    def test_arrangements_are_measured(self):
        for kind, right, wrong in ARRANGEMENTS:
            for bodies, holds in ((right, True), (wrong, False)):
                with self.subTest(kind, holds=holds):
                    names = [b["name"] for b in bodies]
                    found = scene(*bodies).arranged(kind, names)
                    self.assertEqual(any(len(members) == len(names) for members, _ in found), holds)

    def test_gaps_are_between_neighbors(self):
        bodies = cups((-0.15, 0), (0, 0), (0.15, 0))
        ((_, gap_cm),) = scene(*bodies).arranged("row", [b["name"] for b in bodies])
        self.assertAlmostEqual(gap_cm, 5.0)


if __name__ == "__main__":
    unittest.main()
