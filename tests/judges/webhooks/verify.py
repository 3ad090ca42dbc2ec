"""The library of Standard Webhooks verifies messages.

Reads `{"secret": ..., "messages": [{"headers": ..., "body": ...}]}` from standard input, and writes a line of JSON for
each message: its content, or `{"fault": ...}`.
"""

import json
import sys

from standardwebhooks import Webhook, WebhookVerificationError


def main() -> None:
    given = json.load(sys.stdin)
    webhook = Webhook(given["secret"])
    for message in given["messages"]:
        try:
            found = webhook.verify(message["body"], message["headers"])
        except WebhookVerificationError as error:
            found = {"fault": str(error)}
        print(json.dumps(found))


if __name__ == "__main__":
    main()
