"""A page of an allowed origin submits and follows a scene; a page of another origin does neither.

Chromium opens both pages. Without one the protocol is asked as the Fetch standard states it, section 3.3, which a
browser would."""

import http.server
import json
import os
import queue
import shutil
import signal
import subprocess
import tempfile
import threading

from tabletopgen_checks.bars.reliability.part import Finding, yes
from tabletopgen_checks.bars.reliability.scenes import SMALL, request_of
from tabletopgen_checks.problem import Problem

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
PAGE_SECONDS = 60
# What a page does: it submits, follows and downloads, and tells its own origin what happened.
PAGE = """<!doctype html><title>A page</title><script>
(async () => {
  const headers = {authorization: "Bearer KEY", "content-type": "application/json"};
  const found = {};
  try {
    const answer = await fetch("BASE/scenes", {method: "POST", headers, body: JSON.stringify({text: TEXT, seed: SEED})});
    found.submitted = answer.status;
    found.location = answer.headers.get("location");
    const scene = await answer.json();
    const events = await fetch(`BASE/jobs/${scene.job.id}/events`, {headers: {...headers, accept: "text/event-stream"}});
    const reader = events.body.getReader();
    let text = "";
    while (!/job_(succeeded|failed)/.test(text)) {
      const {done, value} = await reader.read();
      if (done) break;
      text += new TextDecoder().decode(value);
    }
    found.followed = (text.match(/job_(succeeded|failed)/) || ["not"])[0];
    const bundle = await fetch(`BASE/scenes/${scene.id}/bundle`, {headers});
    found.bundle_bytes = (await bundle.arrayBuffer()).byteLength;
  } catch (error) { found.error = String(error); }
  await fetch("/found", {method: "POST", body: JSON.stringify(found)});
})();
</script>"""


class Pages:
    """Serves one page, and receives what it found; each port is an origin of its own."""

    def __enter__(self):
        holder = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                content = holder.content.encode()
                self.send_response(200)
                self.send_header("content-type", "text/html; charset=utf-8")
                self.send_header("content-length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

            def do_POST(self):
                holder.found.put(json.loads(self.rfile.read(int(self.headers.get("content-length", 0)))))
                self.send_response(204)
                self.end_headers()

            def log_message(self, *_):
                pass

        self.content, self.found = "", queue.Queue()
        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.origin = f"http://127.0.0.1:{self.server.server_address[1]}"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()


def measure(bench) -> Finding:
    browser, store = next(filter(None, map(shutil.which, BROWSERS)), None), bench.stores()[0]
    with Pages() as allowed, Pages() as other:
        settings = SMALL | {"server.allowed_origins": allowed.origin}
        with bench.keyed(store, f"browser-{store}", settings) as service:
            key = bench.client(service, "page", "read,submit").key
            rows = [asked(service.api, key, "allowed", allowed.origin), asked(service.api, key, "another", other.origin)]
            if browser:
                before = scenes_of(service)
                rows += [seen(browser, service.api, key, name, pages) for name, pages in (("allowed", allowed), ("another", other))]
                made = scenes_of(service) - before
                rows.append(["Chromium", "both", f"{made} scenes made", yes(made == 1)])
    held = all(row[-1] == yes(True) for row in rows)
    how = "Chromium opened a page of each origin, without a head." if browser else "No browser is installed here, so none was asked."
    words = (
        f"{how} Origins are ports of 127.0.0.1. A page has a key of its tenant with `read` and `submit`; the preflight, the "
        "submission and the answer to a page are also asked without a browser, as the Fetch standard has them (section 3.3)."
    )
    return Finding(["asked by", "origin", "found", ""], rows, held, words, full=browser is not None)


def asked(api, key: str, name: str, origin: str) -> list:
    """The requests that a browser would send, and what it would read of the answers."""
    preflight = {"origin": origin, "access-control-request-method": "POST", "access-control-request-headers": "authorization,content-type"}
    status, headers, _ = api.request("OPTIONS", "/scenes", headers=preflight)
    granted = headers.get("access-control-allow-origin") == origin and 200 <= status < 300
    allowed = {word.strip().lower() for word in (headers.get("access-control-allow-headers") or "").split(",")}
    granted &= {"authorization", "content-type"} <= allowed and "POST" in (headers.get("access-control-allow-methods") or "")
    # A cookie may not come along.
    granted &= headers.get("access-control-allow-credentials") is None
    text, seed = request_of(1)
    sent = {"origin": origin, "sec-fetch-site": "cross-site", "content-type": "application/json", "authorization": f"Bearer {key}"}
    status, headers, _ = api.request("POST", "/scenes", json.dumps({"text": text, "seed": seed + len(name)}).encode(), sent)
    readable = headers.get("access-control-allow-origin") == origin
    wanted = (True, 202, True) if name == "allowed" else (False, 403, False)
    found = f"preflight {'granted' if granted else 'denied'}, submission {status}, answer {'readable' if readable else 'not readable'}"
    return ["plain requests", name, found, yes((granted, status, readable) == wanted)]


def seen(browser: str, api, key: str, name: str, pages: Pages) -> list:
    """What a page found in a browser."""
    text, seed = request_of(2)
    content = PAGE.replace("BASE", f"http://127.0.0.1:{api.port}").replace("KEY", key)
    pages.content = content.replace("TEXT", json.dumps(text)).replace("SEED", str(seed))
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [browser, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", f"--user-data-dir={profile}"]
        # It would not end by itself. Its many complaints about what a desktop has and this machine lacks are left out.
        nothing = subprocess.DEVNULL
        process = subprocess.Popen([*command, pages.origin], stdin=nothing, stdout=nothing, stderr=nothing, start_new_session=True)
        try:
            found = pages.found.get(timeout=PAGE_SECONDS)
        except queue.Empty:
            raise Problem(f"{browser} showed the page for {PAGE_SECONDS} s, and it reported nothing") from None
        finally:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    followed = found.get("submitted") == 202 and found.get("followed") == "job_succeeded" and found.get("bundle_bytes", 0) > 0
    blocked = "submitted" not in found and "Failed to fetch" in found.get("error", "")
    return ["Chromium", name, json.dumps(found), yes(followed if name == "allowed" else blocked)]


def scenes_of(service) -> int:
    return int(service.rows("SELECT COUNT(*) FROM scenes")[0][0])
