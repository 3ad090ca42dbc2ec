"""An OpenAI-compatible server of others, LiteLLM's proxy, takes the chat requests that a test left.

    python -m venv V && V/bin/pip install 'litellm[proxy]==1.106.2'
    V/bin/python tests/judges/chat_proxy.py target/chat_requests

Its answers are mocked, valid and invalid ones; it validates them against the schema that each request brings, so that a
schema it does not understand, or does not take for strict, shows. Run by hand: the proxy brings a hundred packages
along.
"""

import json
import os
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from pathlib import Path

KEY = "sk-judge-0123456789"


def main(folder: Path) -> int:
    requests = {path.stem: json.loads(path.read_text()) for path in sorted(folder.glob("*.json"))}
    if not requests:
        print(f"{folder} holds no requests; run `cargo test --test it chat` first")
        return 1
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with tempfile.TemporaryDirectory() as work:
        config = Path(work) / "config.yaml"
        config.write_text(json.dumps(configuration(requests)))
        environment = dict(os.environ, LITELLM_LOCAL_MODEL_COST_MAP="True", LITELLM_MASTER_KEY=KEY)
        litellm = Path(sys.executable).parent / "litellm"
        command = [litellm, "--config", config, "--port", str(port), "--host", "127.0.0.1", "--telemetry", "False"]
        with open(Path(work) / "log", "w") as log:
            proxy = subprocess.Popen(command, env=environment, stdout=log, stderr=log, cwd=work)
        try:
            wait_for(port, proxy, Path(work) / "log")
            return judged(port, requests)
        finally:
            proxy.terminate()
            proxy.wait(30)


def configuration(requests: dict) -> dict:
    """Two models a request: one answers what its schema wants, one something else."""
    models = []
    for name, request in requests.items():
        schema = request["response_format"]["json_schema"]["schema"]
        for kind, answer in (("good", example(schema)), ("bad", {"unasked": True})):
            params = {"model": "openai/gpt-4.1", "api_key": "unused", "mock_response": json.dumps(answer)}
            models.append({"model_name": f"{name}-{kind}", "litellm_params": params})
    return {"model_list": models, "litellm_settings": {"enable_json_schema_validation": True, "num_retries": 0}}


def example(schema: dict):
    """A value of the subset of schemas that strict mode takes."""
    if "enum" in schema:
        return schema["enum"][0]
    kind = schema["type"][0] if isinstance(schema["type"], list) else schema["type"]
    if kind == "object":
        assert set(schema["required"]) == set(schema["properties"]) and schema["additionalProperties"] is False
        return {name: example(inner) for name, inner in schema["properties"].items()}
    if kind == "array":
        return [example(schema["items"])]
    return {"string": "a", "number": 0.5, "integer": 1, "boolean": True}[kind]


def judged(port: int, requests: dict) -> int:
    wrong = 0
    for name, request in requests.items():
        good, answer = ask(port, request | {"model": f"{name}-good"})
        content = json.loads(answer["choices"][0]["message"]["content"]) if good == 200 else answer
        expected = example(request["response_format"]["json_schema"]["schema"])
        bad, refusal = ask(port, request | {"model": f"{name}-bad"})
        held = good == 200 and content == expected and bad != 200 and "JSONSchemaValidationError" in json.dumps(refusal)
        wrong += not held
        print(f"{name}: {'accepted' if held else 'NOT ACCEPTED'} ({good}, another answer {bad})")
        if not held:
            print(json.dumps(answer)[:600], json.dumps(refusal)[:600])
    return 1 if wrong else 0


def ask(port: int, body: dict):
    request = urllib.request.Request(
        f"http://127.0.0.1:{port}/v1/chat/completions",
        json.dumps(body).encode(),
        {"content-type": "application/json", "authorization": f"Bearer {KEY}"},
    )
    try:
        with urllib.request.urlopen(request, timeout=60) as answer:
            return answer.status, json.load(answer)
    except urllib.error.HTTPError as error:
        return error.code, json.loads(error.read() or b"{}")


def wait_for(port: int, proxy, log: Path):
    deadline = time.monotonic() + 180
    while time.monotonic() < deadline and proxy.poll() is None:
        try:
            urllib.request.urlopen(f"http://127.0.0.1:{port}/health/liveliness", timeout=5)
            return
        except OSError:
            time.sleep(0.5)
    raise SystemExit(f"the proxy did not start:\n{log.read_text()[-2000:]}")


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
