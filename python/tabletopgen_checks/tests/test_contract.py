"""The bar `contract`: what it reads of the document and of the fuzzer's report."""

import json
import tempfile
import unittest
from pathlib import Path

from tabletopgen_checks.bars import contract


class Contract(unittest.TestCase):
    def test_operations_are_those_of_the_document(self):
        found = contract.operations()
        self.assertLessEqual({"POST /scenes", "GET /scenes/{scene_id}/artifacts/{name}", "GET /jobs"}, found)
        text = contract.DOCUMENT.read_text(encoding="utf-8")
        # Links name operations deeper.
        self.assertEqual(len(found), sum(line.startswith("      operationId: ") for line in text.splitlines()))

    def test_answers_are_counted_by_operation_and_by_what_was_meant(self):
        def case(mode):
            return {"value": {"method": "GET", "path": "/jobs", "meta": {"generation": {"mode": mode}}}}

        recorder = {
            "cases": {"a": case("positive"), "b": case("negative"), "c": case("positive")},
            "interactions": {
                "a": {"response": {"status_code": 200}},
                "b": {"response": {"status_code": 400}},
                "c": {"response": None},
            },
        }
        lines = [{"PhaseStarted": {}}, {"ScenarioFinished": {"recorder": recorder}}, {"ScenarioFinished": {"recorder": None}}]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "report.ndjson"
            path.write_text("\n".join(map(json.dumps, lines)))
            counted = contract.answers(path)
        self.assertEqual({name: dict(counts) for name, counts in counted.items()},
                         {"GET /jobs": {(True, 2): 1, (False, 4): 1, (True, 0): 1}})


if __name__ == "__main__":
    unittest.main()
