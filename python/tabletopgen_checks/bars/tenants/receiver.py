"""A receiver of webhooks that behaves badly in one way after the other, and then well; and a server inside, which nobody
may reach."""

import http.server
import threading
import time

HANG_SECONDS, BIG_BYTES = 3, 10 << 20
# Ways of a receiver, in the order in which it takes them.
BAD_WAYS = ("fails", "hangs", "redirects inside", "answers 10 MB")


class Receiver:
    """Keeps what it was sent, with whether it accepted that."""

    def __enter__(self):
        receiver = self
        self.way, self.messages, self.inside = BAD_WAYS[0], [], 0

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers.get("content-length", 0))).decode()
                way, headers = receiver.way, {name.lower(): value for name, value in self.headers.items()}
                receiver.messages.append({"way": way, "headers": headers, "body": body})
                if way == "hangs":
                    time.sleep(HANG_SECONDS)
                status = {"accepts": 204, "redirects inside": 307}.get(way, 500)
                content = b"x" * BIG_BYTES if way == "answers 10 MB" else b""
                try:
                    self.send_response(status)
                    if status == 307:
                        self.send_header("location", f"http://127.0.0.1:{receiver.hidden.server_address[1]}/inside")
                    self.send_header("content-length", str(len(content)))
                    self.end_headers()
                    self.wfile.write(content)
                except OSError:
                    # The sender had enough.
                    pass

            def log_message(self, *_):
                pass

        class Inside(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                receiver.inside += 1
                self.send_response(204)
                self.end_headers()

            do_GET = do_POST

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.hidden = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Inside)
        for server in (self.server, self.hidden):
            server.daemon_threads = True
            threading.Thread(target=server.serve_forever, daemon=True).start()
        self.host = f"127.0.0.1:{self.server.server_address[1]}"
        self.hidden_host = f"127.0.0.1:{self.hidden.server_address[1]}"
        return self

    def __exit__(self, *_):
        for server in (self.server, self.hidden):
            server.shutdown()
            server.server_close()
