"""A stand-in for nginx with `auth_request` and oauth2-proxy: one user is logged in, and named to the server in the
headers that a configuration sets.

Of the configuration it knows what the documents use: `auth_request_set`, `proxy_set_header` and `proxy_pass` of one
location. Other headers of a client go on as they came. Standard library only."""

import http.client
import http.server
import re
import threading

from tabletopgen_checks.problem import Problem

# What oauth2-proxy answers about one who is logged in.
LOGGED_IN = {"x_auth_request_email": "ann@example.org", "x_auth_request_groups": "staff,read,submit"}


class LoginProxy:
    """On a port of this machine."""

    def __init__(self, configuration: str, port: int):
        self.port = port
        words = re.sub(r"#.*", "", configuration)
        self.names = dict(re.findall(r"auth_request_set\s+\$(\w+)\s+\$upstream_http_(\w+);", words))
        self.headers = dict(re.findall(r"proxy_set_header\s+(\S+)\s+(\S+);", words))
        passed = re.search(r"proxy_pass\s+http://([\w.]+):(\d+);", words)
        if not passed or not self.names or not self.headers:
            raise Problem("the configuration of the proxy has no auth_request_set, proxy_set_header or proxy_pass")
        self.upstream = passed[1], int(passed[2])

    def value(self, word: str, client: str, host: str) -> str:
        known = {"remote_addr": client, "host": host} | {name: LOGGED_IN[of] for name, of in self.names.items()}
        return re.sub(r"\$(\w+)", lambda found: known[found[1]], word).strip('"')

    def __enter__(self):
        proxy = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                replaced = {name.lower() for name in proxy.headers} | {"connection"}
                headers = {name: value for name, value in self.headers.items() if name.lower() not in replaced}
                client, host = self.client_address[0], self.headers.get("host", "")
                headers |= {name: proxy.value(word, client, host) for name, word in proxy.headers.items()}
                connection = http.client.HTTPConnection(*proxy.upstream, timeout=60)
                try:
                    body = self.rfile.read(int(self.headers.get("content-length", 0)))
                    connection.request(self.command, self.path, body or None, headers)
                    answer = connection.getresponse()
                    status, kind, content = answer.status, answer.headers.get("content-type", ""), answer.read()
                except OSError:
                    status, kind, content = 502, "text/plain", b""
                finally:
                    connection.close()
                self.send_response(status)
                self.send_header("content-type", kind)
                self.send_header("content-length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

            do_POST = do_PATCH = do_DELETE = do_GET

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", self.port), Handler)
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()
