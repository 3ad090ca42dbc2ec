"""The fuzzer of the bar `contract` over every operation, with the key of an administrator."""

from tabletopgen_checks.bars import contract
from tabletopgen_checks.bars.page import table
from tabletopgen_checks.bars.reliability.part import Finding
from tabletopgen_checks.bars.tenants.bench import command
from tabletopgen_checks.problem import Problem


def measure(bench) -> Finding:
    python, store = contract.environment(bench.given.target_dir / "contract"), bench.stores()[0]
    with contract.ImageServer() as images:
        settings = dict(setting.split("=") for setting in (*contract.QUICK, f"server.fetch_hosts=127.0.0.1:{images.port}"))
        with bench.keyed(store, f"fuzzing-{store}", settings) as service:
            client = bench.client(service)
            scene = contract.finished_scene(client)
            command(service, "queue", "pause", "--reason", "requests are fuzzed")
            report = contract.fuzz(python, service.folder, client, images, scene, bench.given.examples, bench.given.fuzz_seed)
            if service.api.request("GET", "/healthz")[0] != 200:
                raise Problem(f"the server does not answer any more\n{service.api.words()}")
    found, reached = contract.summary(report), set(report["answers"]) & contract.operations()
    held = report["complete"] and not found.mismatches and not found.server_errors and reached == contract.operations()
    rows = [[store, len(reached), len(contract.operations()), found.sent, found.accepted, found.server_errors, found.count]]
    words = (
        f"Schemathesis {report['schemathesis_version']}, all its checks, {bench.given.examples} examples an operation, seed "
        f"{report['seed']}, {report['seconds']:.0f} s. Every request has the key of an administrator, with all scopes; hooks keep the "
        "fuzzer from revoking it. [contract.md](contract.md) has the same for a server without authentication, by operation."
    )
    if found.mismatches:
        words += "\n\n" + table(contract.MISMATCH_COLUMNS, found.mismatches)
    columns = ["store", "operations reached", "of", "requests", "of these answered with 2xx", "server errors", "mismatches"]
    return Finding(columns, rows, held, words, full=bench.given.examples >= contract.FULL_EXAMPLES)
