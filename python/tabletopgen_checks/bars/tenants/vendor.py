"""A vendor whose answer takes a while and refuses: each job takes as long, and next to no processor time.

So turns at workers are measured, not the processor, of which there are two here."""

import http.server
import multiprocessing
import time

ANSWER_SECONDS = 0.1


class Vendor(http.server.ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request, client_address):
        """Those who ask may go before they are answered."""


class Refusing(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def do_POST(self):
        self.rfile.read(int(self.headers.get("content-length", 0)))
        time.sleep(ANSWER_SECONDS)
        content = b'{"error": {"message": "not today", "type": "invalid_request_error"}}'
        self.send_response(400)
        self.send_header("content-type", "application/json")
        self.send_header("content-length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_):
        pass


def serve(port):
    server = Vendor(("127.0.0.1", 0), Refusing)
    port.send(server.server_address[1])
    server.serve_forever()


class RefusingVendor:
    """In a process of its own."""

    def __enter__(self):
        here, there = multiprocessing.Pipe()
        self.process = multiprocessing.Process(target=serve, args=(there,), daemon=True)
        self.process.start()
        self.port = here.recv()
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.join()

    def settings(self) -> dict:
        return {
            "providers.analyst": "chat",
            "providers.allow_http": "true",
            "providers.private_hosts": "127.0.0.1",
            "providers.chat.base_url": f"http://127.0.0.1:{self.port}/v1",
            "providers.chat.calls_per_minute": "1000000",
        }
