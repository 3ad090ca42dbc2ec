"""The search for room and its geometry, against cases by hand and slow references."""

import math
import unittest

from tabletopgen_checks.edits.comparison import Operation
from tabletopgen_checks.edits.refusals import place_for
from tabletopgen_checks.edits.room import Prism, box, free_place, layered, levels_of, obstacles_of
from tabletopgen_checks.scene.polygons import (
    area_m2,
    convex_hull,
    depth_m,
    distance_m,
    minkowski_sum,
    outline_holds,
    rows_of,
    shifted,
    simplified,
    turned,
)
from tabletopgen_checks.tests.made_up_scenes import MUG, OUTLINE, PLATE, body, cup, scene

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


class Geometry(unittest.TestCase):
    def test_distances_are_those_by_hand(self):
        self.assertAlmostEqual(distance_m(SQUARE, shifted(SQUARE, (1.5, 0.3))), 0.5)
        self.assertAlmostEqual(distance_m(SQUARE, shifted(SQUARE, (1.3, 1.4))), 0.5)
        self.assertAlmostEqual(distance_m(SQUARE, shifted(SQUARE, (0.9, 0.0))), -0.1)
        self.assertAlmostEqual(depth_m(SQUARE, (0.5, 0.2)), 0.2)
        self.assertAlmostEqual(depth_m(SQUARE, (0.5, -0.2)), -0.2)

    def test_the_sum_of_polygons_is_the_hull_of_the_sums_of_their_corners(self):
        for k in range(12):
            one = turned(SQUARE, 0.3 * k)
            other = turned([(0.0, 0.0), (2.0, 0.0), (0.5, 0.7)], 0.5 * k)
            slow = convex_hull([(p[0] + q[0], p[1] + q[1]) for p in one for q in other])
            self.assertAlmostEqual(area_m2(minkowski_sum(one, other)), area_m2(slow))

    def test_simplified_polygons_keep_within_the_tolerance(self):
        circle = [(0.1 * math.cos(0.05 * k), 0.1 * math.sin(0.05 * k)) for k in range(125)]
        found = simplified(circle)
        self.assertLess(len(found), 40)
        self.assertTrue(all(depth_m(found, corner) >= -0.001 - 1e-9 for corner in circle))
        self.assertEqual(simplified(SQUARE), SQUARE)

    def test_rows_are_cut_where_the_polygon_is(self):
        found = rows_of([(0.0, 0.0), (2.0, 0.0), (0.0, 2.0)], -0.5, 0.5, 9)
        self.assertEqual(sorted(found), [1, 2, 3, 4, 5])
        self.assertEqual(found[2], (0.0, 1.5))

    def test_a_notch_between_the_corners_is_outside(self):
        notched = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 0.0), (-1.0, 1.0)]
        low, high = [(-0.2, -0.5), (0.2, -0.5), (0.2, -0.3), (-0.2, -0.3)], [(-0.4, 0.2), (-0.3, -0.5), (0.4, 0.2)]
        self.assertTrue(outline_holds(notched, low, 0.01))
        self.assertFalse(outline_holds(notched, convex_hull(high), 0.0))


class Room(unittest.TestCase):
    def test_a_gap_of_the_width_and_twice_the_clearance_is_room(self):
        # Two walls from the front to the back edge.
        for gap_m, expected in ((0.16, True), (0.11, False)):
            wall = (0.3, 0.6, 0.2)
            walls = [body("a_1", -0.5 * gap_m - 0.15, 0, size=wall), body("b_1", 0.5 * gap_m + 0.15, 0, size=wall),
                     body("c_1", -0.5 * gap_m - 0.45, 0, size=wall), body("d_1", 0.5 * gap_m + 0.45, 0, size=wall)]
            found = scene(*walls)
            place = free_place(found, box((0.1, 0.1, 0.1)), obstacles_of(found), levels_of(found, "table"))
            self.assertEqual(place is not None, expected)

    def test_a_found_place_touches_nothing(self):
        found = scene(*(body(f"a_{k}", -0.5 + 0.2 * k, 0.1 * (k % 3 - 1), yaw_deg=17 * k) for k in range(6)))
        place = free_place(found, box((0.15, 0.08, 0.1)), obstacles_of(found), levels_of(found, "table"))
        assert place is not None
        for other in found.bodies.values():
            self.assertGreaterEqual(distance_m(place.footprint, other.footprint), 0.01 - 1e-9)
        self.assertTrue(outline_holds(found.outline, place.footprint, 0.01 - 1e-9))

    def test_outlines_bound_the_search_whether_convex_or_not(self):
        notched = [[-0.6, -0.3], [0.6, -0.3], [0.6, 0.3], [0.0, -0.2], [-0.6, 0.3]]
        shape = box((0.303, 0.207, 0.1))
        for outline, straight in ((OUTLINE, 0), (notched, 0), (OUTLINE, 3)):
            found = scene()
            found.outline = [tuple(corner) for corner in outline]
            yaws = [0.1 * straight]
            slow = [
                (round(x / 100 - 0.6, 3), round(y / 100 - 0.3, 3)) for x in range(121) for y in range(61)
                if outline_holds(found.outline, shifted(turned(shape.prisms[0].polygon, yaws[0]),
                                                        (x / 100 - 0.6, y / 100 - 0.3)), 0.01)
            ]
            seen = []
            free_place(found, shape, [], levels_of(found, "table"), yaws=yaws,
                       accepts=lambda place, seen=seen: seen.append(place) or False)
            if outline is OUTLINE:
                self.assertEqual(sorted((round(p.center[0], 3), round(p.center[1], 3)) for p in seen), sorted(slow))
            place = free_place(found, shape, [], levels_of(found, "table"), yaws=yaws)
            assert place is not None
            self.assertTrue(outline_holds(found.outline, place.footprint, 0.01 - 1e-9))

    def test_layers_enclose_the_hulls_at_their_heights(self):
        # A lamp: a small base, a pole, and a shade to one side.
        parts = [((0.1, 0.1), 0.0, 0.02, 0.0), ((0.02, 0.02), 0.02, 0.4, 0.0), ((0.2, 0.1), 0.31, 0.4, 0.15)]
        prisms = [Prism(shifted([(-0.5 * x, -0.5 * y), (0.5 * x, -0.5 * y), (0.5 * x, 0.5 * y), (-0.5 * x, 0.5 * y)],
                                (aside, 0.0)), low, high) for (x, y), low, high, aside in parts]
        found = layered(prisms * 2)
        self.assertEqual(len(found), 4)
        for one in prisms:
            for layer in found:
                if one.low_m < layer.high_m and one.high_m > layer.low_m:
                    self.assertTrue(all(depth_m(layer.polygon, corner) >= -1e-9 for corner in one.polygon))
        widths = [max(x for x, _ in layer.polygon) for layer in found]
        self.assertEqual([round(width, 3) for width in widths], [0.05, 0.01, 0.01, 0.25])

    def test_a_turned_object_fits_where_a_straight_one_does_not(self):
        walls = scene(body("a_1", -0.35, 0, size=(0.5, 0.6, 0.2)), body("b_1", 0.35, 0, size=(0.5, 0.6, 0.2)))
        shape = box((0.3, 0.1, 0.1))
        self.assertIsNone(free_place(walls, shape, obstacles_of(walls), levels_of(walls, "table"), yaws=[0.0]))
        self.assertIsNotNone(free_place(walls, shape, obstacles_of(walls), levels_of(walls, "table")))

    def test_what_is_above_is_no_obstacle(self):
        shelf = scene(body("a_1", 0, 0, 0.3, size=(1.2, 0.6, 0.1)))
        for height_m, expected in ((0.2, True), (0.35, False)):
            shape = box((0.1, 0.1, height_m))
            place = free_place(shelf, shape, obstacles_of(shelf), levels_of(shelf, "table"))
            self.assertEqual(place is not None, expected)

    def test_containers_take_what_fits_between_their_walls(self):
        container, hulls = cup("cup_1", 0.0, 0.0)
        operation = Operation({"op": "move", "target": "a_1", "where": {"relation": "in", "target": "cup_1"}}, ["a_1"],
                              ["cup_1"])
        for size, expected in (((0.05, 0.05, 0.05), True), ((0.11, 0.11, 0.05), False)):
            found = scene(container, body("a_1", 0.4, 0, size=size), hulls={"cup_1": hulls})
            self.assertEqual(bool(place_for(operation, found)), expected)

    def test_a_turn_is_tried_at_its_place_only(self):
        turn = Operation({"op": "rotate", "target": "a_1", "by_rad": 0.5 * math.pi}, ["a_1"])
        for y, expected in ((0.1, True), (0.155, False)):
            found = scene(body("a_1", 0.0, y, size=(0.3, 0.1, 0.1)))
            self.assertEqual(bool(place_for(turn, found)), expected)

    def test_refusals_of_single_operations_are_tried(self):
        blocks = [body("a_1", -0.3, 0.15, size=(0.58, 0.28, 0.2)), body("b_1", 0.3, 0.15, size=(0.58, 0.28, 0.2)),
                  body("c_1", -0.3, -0.15, size=(0.58, 0.28, 0.2))]
        free = scene(*blocks, body("mug_1", 0.4, -0.15))
        blocks.append(body("d_1", 0.3, -0.15, size=(0.58, 0.28, 0.2)))
        full = scene(*blocks, body("mug_1", 0.3, 0.15, 0.2, parent="b_1"))
        cases_of = [
            Operation({"op": "add", "object": "a mug"}, categories=("mug",), count=1),
            Operation({"op": "move", "target": "mug_1", "where": {"relation": "at_right"}}, ["mug_1"]),
            Operation({"op": "clutter", "count": 1}, count=1),
            Operation({"op": "tidy"}),
        ]
        for operation in cases_of[:3]:
            self.assertTrue(place_for(operation, free), operation.wire)
            self.assertFalse(place_for(operation, full), operation.wire)
        self.assertTrue(place_for(cases_of[3], scene(MUG, PLATE)))
        self.assertTrue(place_for(Operation({"op": "stack", "targets": ["plate_1", "mug_1"]}, ["plate_1", "mug_1"]),
                                  scene(MUG, PLATE)))
        rotate = Operation({"op": "rotate", "target": "a_1", "by_rad": 1.5}, ["a_1"])
        self.assertFalse(place_for(rotate, free))
        self.assertTrue(place_for(Operation({"op": "rotate", "target": "mug_1", "by_rad": 1.5}, ["mug_1"]), free))
        self.assertTrue(place_for(Operation({"op": "relabel", "target": "mug_1", "label": "x"}, ["mug_1"]), full))


if __name__ == "__main__":
    unittest.main()
