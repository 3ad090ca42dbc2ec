"""The bar `tenants`: the search for secrets. And the stand-in of a proxy that logs users in."""

import base64
import http.client
import http.server
import json
import threading
import unittest

from tabletopgen_checks.bars.tenants.secrets import Secrets, cookie_of
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.service.login_proxy import LoginProxy
from tabletopgen_checks.service.postgres import free_port

KEY = "tt_0a1b2c3d4e5f6g7h8i9j0k1l2m3n4o5p6q7r8s9t0uA"
CONFIGURATION = """
location / {
    auth_request_set $email  $upstream_http_x_auth_request_email;
    proxy_set_header X-User  $email;     # replaces the client's
    proxy_set_header Host    $host;
    proxy_pass       http://127.0.0.1:PORT;
}
"""


class SearchForSecrets(unittest.TestCase):
    def found_in(self, content: bytes) -> list:
        secrets = Secrets()
        secrets.add("key", KEY)
        secrets.search("log", content)
        return secrets.found

    def test_a_secret_is_found_in_every_form(self):
        for shift in range(3):
            self.assertEqual(self.found_in(b"before" + base64.b64encode(b"x" * shift + KEY.encode() + b"after")), ["key (0) in the log"])
        self.assertEqual(self.found_in(b'{"key": "' + KEY.encode() + b'"}'), ["key (0) in the log"])
        # What every key begins with is no secret.
        self.assertEqual(self.found_in(b"tt_ and " + base64.b64encode(KEY[::-1].encode())), [])

    def test_a_place_without_its_mark_was_not_read(self):
        secrets = Secrets()
        secrets.search("log", b"a line about 17", "17")
        with self.assertRaises(Problem):
            secrets.search("log", b"", "17")

    def test_the_cookie_of_an_answer(self):
        self.assertEqual(cookie_of({"set-cookie": "tt_session=abc; HttpOnly"}), "abc")
        with self.assertRaises(Problem):
            cookie_of({})


class ProxyThatLogsIn(unittest.TestCase):
    def test_headers_of_the_configuration_replace_those_of_the_client(self):
        class Upstream(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                content = json.dumps({name.lower(): value for name, value in self.headers.items()}).encode()
                self.send_response(200)
                self.send_header("content-length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

            def log_message(self, *_):
                pass

        upstream = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Upstream)
        threading.Thread(target=upstream.serve_forever, daemon=True).start()
        configuration = CONFIGURATION.replace("PORT", str(upstream.server_address[1]))
        with LoginProxy(configuration, free_port()) as proxy:
            connection = http.client.HTTPConnection("127.0.0.1", proxy.port)
            connection.request("GET", "/", headers={"x-user": "root", "x-other": "kept"})
            seen = json.loads(connection.getresponse().read())
            connection.close()
        upstream.shutdown()
        upstream.server_close()
        self.assertEqual((seen["x-user"], seen["x-other"]), ("ann@example.org", "kept"))
        with self.assertRaises(Problem):
            LoginProxy("location / {}", 1)


if __name__ == "__main__":
    unittest.main()
