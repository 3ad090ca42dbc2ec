"""What the bar of reliability reads out of events and logs, and what it draws."""

import json
import tempfile
import unittest
import xml.etree.ElementTree
from pathlib import Path

from tabletopgen_checks.bars.reliability import audit, bare, plot
from tabletopgen_checks.bars.reliability.__main__ import KEPT, page_of
from tabletopgen_checks.bars.reliability.audit import Worked, repeated_among
from tabletopgen_checks.bars.reliability.kinds import KINDS, Aims, HeldJob, hits_among, recording_complaints, usual_seconds
from tabletopgen_checks.bars.reliability.orders import differences
from tabletopgen_checks.bars.reliability.proxy import Proxy
from tabletopgen_checks.bars.reliability.scenes import complaints, quantile, tally
from tabletopgen_checks.bars.reliability.soak import growth_of
from tabletopgen_checks.repository import RESULTS
from tabletopgen_checks.result_pages import measurements

SCENE, JOB = "0193aaaa-0000-7000-8000-000000000001", "0193aaaa-0000-7000-8000-000000000002"
LOG = f"""2026-01-02 03:04:05.678 UTC [7] LOG:  statement: BEGIN
2026-01-02 03:04:05.678 UTC [9] LOG:  statement: BEGIN
2026-01-02 03:04:05.678 UTC [9] LOG:  execute s1: UPDATE jobs SET lease_until = $1
2026-01-02 03:04:05.678 UTC [9] DETAIL:  parameters: $1 = '5'
2026-01-02 03:04:05.678 UTC [7] LOG:  execute s2: SAVEPOINT operation
2026-01-02 03:04:05.678 UTC [7] LOG:  execute s3: SELECT CAST(EXTRACT(EPOCH FROM clock_timestamp()) * 1000 AS BIGINT)
2026-01-02 03:04:05.678 UTC [9] LOG:  statement: COMMIT
2026-01-02 03:04:05.678 UTC [7] LOG:  execute s4: INSERT INTO scenes (id, request,
\t    labels, parent_id) VALUES ($1, $2, $3, $4)
2026-01-02 03:04:05.678 UTC [7] DETAIL:  parameters: $1 = '{SCENE}', $2 = '{{"text":"it''s"}}', $3 = '{{}}', $4 = NULL
2026-01-02 03:04:05.678 UTC [7] LOG:  execute s5: INSERT INTO events (job_id, data) VALUES ($1, $2)
2026-01-02 03:04:05.678 UTC [7] DETAIL:  parameters: $1 = '{JOB}', $2 = '{{"scene_id":"{SCENE}"}}'
2026-01-02 03:04:05.678 UTC [7] LOG:  execute s6: SELECT pg_notify('jobs', '')
2026-01-02 03:04:05.678 UTC [7] LOG:  statement: COMMIT
"""


def event(seq, kind, stage="", **data):
    return {"seq": seq, "kind": kind, "data": dict({"stage": stage} if stage else {}, **data)}


class Complaints(unittest.TestCase):
    def test_a_job_taken_over_is_as_it_should_be(self):
        events = [
            event(1, "job_started"),
            event(2, "stage_started", "place"),
            event(3, "job_started"),
            event(4, "stage_started", "place"),
            event(5, "stage_finished", "place", cached=False),
            event(6, "job_started"),
            event(7, "stage_finished", "place", cached=True),
            event(8, "job_succeeded"),
        ]
        self.assertEqual(complaints(events), [])

    def test_repetition_double_commit_and_loss_are_distinguished(self):
        events = [
            event(1, "stage_started", "place"),
            event(2, "stage_finished", "place", cached=False),
            event(3, "stage_started", "place"),
            event(4, "stage_finished", "place", cached=False),
        ]
        self.assertEqual(tally(complaints(events)), {"lost": 1, "repeated": 1, "twice": 1, "bytes": 0})

    def test_instances_of_a_stage_are_different(self):
        events = [
            event(1, "stage_started", "rotate", instance="a"),
            event(2, "stage_finished", "rotate", instance="a"),
            event(3, "stage_started", "rotate", instance="b"),
            event(4, "stage_finished", "rotate", instance="b"),
            event(5, "job_succeeded"),
        ]
        self.assertEqual(complaints(events), [])


class Numbers(unittest.TestCase):
    def test_quantile_of_few(self):
        self.assertEqual(quantile([3, 1, 2], 0.5), 2)
        self.assertEqual(quantile(range(1, 101), 0.99), 99)
        self.assertEqual(quantile([7], 0.99), 7)

    def test_growth_is_that_of_the_second_half(self):
        rises_first = [(x, min(x, 10)) for x in range(21)]
        self.assertAlmostEqual(growth_of(rises_first), 0.0)
        self.assertAlmostEqual(growth_of([(x, 100 + x) for x in range(20)]), 9 / 114.5)


class Statements(unittest.TestCase):
    def test_the_transaction_of_a_submission_is_found_in_the_log(self):
        found = bare.transaction_in(LOG)
        self.assertEqual([sql.split()[0] for sql, _ in found], ["SELECT", "INSERT", "INSERT", "SELECT"])
        self.assertEqual(found[1][1], {1: SCENE, 2: '{"text":"it\'s"}', 3: "{}", 4: None})

    def test_every_run_of_the_script_has_ids_of_its_own(self):
        script = bare.script_for_pgbench(bare.transaction_in(LOG))
        self.assertNotIn(SCENE, script)
        self.assertEqual(script.count(":run::text"), 3)
        self.assertIn("labels, parent_id) VALUES", script)
        self.assertNotIn("$", script)

    def test_the_same_on_sqlite(self):
        import sqlite3

        translated = bare.for_sqlite(bare.transaction_in(LOG))
        self.assertEqual(len(translated), 3)
        connection = sqlite3.connect(":memory:")
        connection.execute("CREATE TABLE scenes (id, request, labels, parent_id)")
        connection.execute("CREATE TABLE events (job_id, data)")
        for sql, parameters in translated:
            fresh = {SCENE: "new", JOB: "job"}
            values = {str(n): bare.renewed(value, fresh) for n, value in parameters.items()}
            connection.execute(sql, values).fetchall()
        self.assertEqual(
            connection.execute("SELECT * FROM scenes").fetchall(), [("new", '{"text":"it\'s"}', "{}", None)]
        )
        self.assertEqual(connection.execute("SELECT data FROM events").fetchone(), ('{"scene_id":"new"}',))


class Plots(unittest.TestCase):
    def test_a_plot_is_well_formed(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "plot.svg"
            plot.draw(
                path,
                "a < b",
                [("memory", "MB", [("all", [(0.0, 1.0), (1.0, 3.0)])]), ("nothing", "", [("all", [(0.0, 0.0)])])],
            )
            root = xml.etree.ElementTree.parse(path).getroot()
            self.assertEqual(len(root.findall("{http://www.w3.org/2000/svg}polyline")), 2)


class Proxies(unittest.TestCase):
    def test_what_is_held_arrives_after_the_release(self):
        import socket
        import threading

        with socket.create_server(("127.0.0.1", 0)) as echo:

            def answer():
                connection, _ = echo.accept()
                with connection:
                    connection.sendall(connection.recv(16).upper())

            threading.Thread(target=answer, daemon=True).start()
            with Proxy(echo.getsockname()[1]) as proxy:
                proxy.hold()
                with socket.create_connection(("127.0.0.1", proxy.port), timeout=5) as client:
                    client.sendall(b"abc")
                    client.settimeout(0.2)
                    with self.assertRaises(TimeoutError):
                        client.recv(16)
                    client.settimeout(5)
                    proxy.release()
                    self.assertEqual(client.recv(16), b"ABC")
                proxy.refuse()
                with self.assertRaises(ConnectionRefusedError):
                    socket.create_connection(("127.0.0.1", proxy.port), timeout=5)


class LateWrites(unittest.TestCase):
    def late(self, *rows):
        return audit.late_among([(user, inside, takes, table, "job") for user, inside, takes, table in rows])

    def test_a_rescue_and_what_follows_it_are_in_time(self):
        rows = [
            ("worker0", "1", "claim", "jobs"),
            ("worker0", "2", "", "stages"),
            ("worker1", "3", "", "jobs"),
            ("worker1", "3", "rescue", "jobs"),
            ("worker1", "3", "", "events"),
            ("worker1", "4", "claim", "jobs"),
            ("worker1", "5", "", "stages"),
        ]
        self.assertEqual(self.late(*rows), [])

    def test_what_the_worker_of_before_writes_is_late(self):
        begin = [("worker0", "1", "claim", "jobs"), ("worker1", "2", "rescue", "jobs")]
        self.assertEqual(len(self.late(*begin, ("worker0", "3", "", "stages"))), 1)
        claim = ("worker1", "3", "claim", "jobs")
        self.assertEqual(len(self.late(*begin, claim, ("worker0", "4", "", "events"))), 1)
        self.assertEqual(len(self.late(begin[0], ("worker1", "2", "", "stages"))), 1, "without a claim")


def worked(what, owner="one", kind="execute_task", subject="a", at_ms=0):
    return Worked(what, kind, subject, f"job of {subject}", owner, at_ms)


class WorkOfAllKinds(unittest.TestCase):
    def test_work_that_is_claimed_after_a_death_is_not_repeated(self):
        rows = [worked("claimed"), worked("orphaned"), worked("claimed", "two"), worked("done", "two")]
        self.assertEqual(repeated_among(rows), [])
        self.assertEqual(repeated_among([*rows, worked("claimed", subject="b"), worked("done", subject="b")]), [])

    def test_work_that_is_claimed_after_its_end_is_repeated(self):
        rows = [worked("claimed"), worked("done"), worked("claimed", "two"), worked("done", "two")]
        self.assertEqual(tally(repeated_among(rows)), {"lost": 0, "repeated": 1, "twice": 1, "bytes": 0})

    def test_a_kill_hits_all_that_its_process_held(self):
        rows = [
            worked("orphaned", "one", "execute_task", "a"),
            worked("orphaned", "one", "execute_task", "b"),
            worked("orphaned", "one", "freeze_dataset"),
            worked("orphaned", "two", "execute_task"),
            worked("orphaned", "slow", "generate"),
            worked("done", "two", "verify_dataset"),
        ]
        self.assertEqual(hits_among(rows, ["one", "two"]), {"execute_task": 2, "freeze_dataset": 1})

    def test_usual_time_is_that_since_the_last_claim(self):
        rows = [worked("claimed"), worked("claimed", at_ms=500), worked("done", at_ms=2000)]
        self.assertEqual(usual_seconds(rows), {"execute_task": 1.5})

    def test_a_kill_is_aimed_at_the_kind_with_the_greatest_rest(self):
        aims = Aims(6 * len(KINDS) + 2, {"generate": 2.0}, 1)
        generate, freeze = HeldJob("a", "generate", "one", ""), HeldJob("b", "freeze_dataset", "one", "")
        self.assertEqual(aims.target([freeze, generate]), generate)
        aims.take(generate)
        aims.take(generate)
        self.assertEqual(aims.target([freeze, generate]), freeze)
        for _ in range(2):
            aims.take(generate)
        self.assertIsNone(aims.target([generate]), "one job is not aimed at for ever")
        self.assertLessEqual(aims.delay_seconds("generate"), 2.0)
        self.assertIsNone(aims.target([]))
        self.assertEqual(aims.left.total(), 6 * len(KINDS) + 2 - 4)

    def test_missing_and_other_results_are_distinguished(self):
        calm = {"scene": {"bundle": "1"}, "recording": {"a": "1", "b": "2"}, "dataset": {"manifest": "3"}}
        self.assertEqual(differences(calm, dict(calm)), [])
        found = {"scene": {"bundle": "1"}, "recording": {"a": "1", "c": "2"}}
        self.assertEqual(differences(calm, found), ["lost: dataset is missing", "bytes: recording differs in b, c"])

    def test_attempts_made_twice_are_found_in_the_events_of_a_recording(self):
        def made(number):
            return event(1, "attempt", number=number, outcome="success")

        sound = [event(1, "queued"), made(1), made(0), event(1, "assembling"), event(1, "finished")]
        self.assertEqual(recording_complaints(sound), [])
        wrong = tally(recording_complaints([made(0), made(0), event(1, "attempt_lost", number=0)]))
        self.assertEqual(wrong, {"lost": 2, "repeated": 1, "twice": 0, "bytes": 0})


class Page(unittest.TestCase):
    def test_the_page_is_made_of_what_is_kept(self):
        written, made = (RESULTS / "reliability.md").read_text(encoding="utf-8"), page_of(json.loads(KEPT.read_text(encoding="utf-8")))
        self.assertEqual(measurements("reliability.md", made), measurements("reliability.md", written))


if __name__ == "__main__":
    unittest.main()
