"""The receiver of webhooks answers by a script, and keeps what it gets."""

import http.client
import time
import unittest

from tabletopgen_checks.webhook_receiver import Answer, WebhookReceiver


def sent(receiver: WebhookReceiver, body: str, timeout_s: float = 10) -> tuple:
    """Status, address and length of the answer to a POST."""
    connection = http.client.HTTPConnection("127.0.0.1", receiver.port, timeout=timeout_s)
    try:
        connection.request("POST", "/hook", body, {"webhook-id": "msg_1"})
        answer = connection.getresponse()
        return answer.status, answer.getheader("location"), len(answer.read())
    finally:
        connection.close()


class Receivers(unittest.TestCase):
    def test_answers_come_in_their_order_and_then_204(self):
        answers = [Answer(500), Answer(307, location="http://127.0.0.1/"), Answer(200, size_bytes=100_000)]
        with WebhookReceiver(answers) as receiver:
            found = [sent(receiver, str(k)) for k in range(4)]
            self.assertEqual(found, [(500, None, 0), (307, "http://127.0.0.1/", 0), (200, None, 100_000), (204, None, 0)])
            received = receiver.wait(4)
        self.assertEqual([one.body for one in received], ["0", "1", "2", "3"])
        self.assertEqual({one.headers["webhook-id"] for one in received}, {"msg_1"})

    def test_silence_holds_up_no_other_and_ends_with_the_receiver(self):
        with WebhookReceiver([Answer(after_s=600)]) as receiver:
            with self.assertRaises(TimeoutError):
                sent(receiver, "first", timeout_s=0.3)
            self.assertEqual(sent(receiver, "second")[0], 204)
            began = time.monotonic()
        self.assertLess(time.monotonic() - began, 10)


if __name__ == "__main__":
    unittest.main()
