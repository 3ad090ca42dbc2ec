"""`make test`: everything, from formatting to independent programs that judge what comes out.

    PYTHONPATH=python python3 -m tabletopgen_checks.test [--target-dir target] [--only edits]

Stops at the first step that fails and says which; the last line is a summary either way. `--only` runs one step of
those again.
"""

import argparse
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tabletopgen_checks import cargo_results, client, lint, page, tools
from tabletopgen_checks import documents as documented
from tabletopgen_checks.edits import sample as edit_sample
from tabletopgen_checks.judges import rest_sample
from tabletopgen_checks.judges.judging import JUDGE_NAMES, complaints, finish_setup, judge_beside, start_setup
from tabletopgen_checks.language import sample as words_sample
from tabletopgen_checks.language.sentences import sentences
from tabletopgen_checks.problem import Problem
from tabletopgen_checks.processes import BackgroundProgram
from tabletopgen_checks.repository import JUDGES, PYTHON, ROOT
from tabletopgen_checks.robots import sample as robot_sample
from tabletopgen_checks.scene.generation import differing_files, generate
from tabletopgen_checks.scene.scene import read_scene
from tabletopgen_checks.service import postgres
from tabletopgen_checks.step_report import StepReport

CARGO = os.environ.get("CARGO", "cargo")
KILLS = 6
# The bar of reliability with counts that take less than a minute.
RELIABILITY = ["--only", "kills,posts", "--kills", "8", "--posts", "50"]
# The bar of tenants with counts that take less than two minutes. tests/it/api/access.rs has its matrix; its soak
# measures times, which a machine with other work does not keep.
TENANTS = ["--only", "deletion,secrets", "--stores", "sqlite", "--scenes", "20", "--others", "1", "--grace-seconds", "10"]
# Drake and PyBullet take up to a minute of processor time per simulated second, and the README's examples two minutes.
# The first scene gets a second and the examples, some more get a quarter of a second, and the others are not simulated
# there; the bars give all of them half a second.
SLOW_JUDGES = ("bullet", "sdf")
JUDGED_LONGER, JUDGED_BRIEFLY = 1, 3
SLOW_SECONDS_LONGER, SLOW_SECONDS = 1.0, 0.25
# The judges' own test breaks a bundle five dozen times: the smaller the better.
SMALL_SCENE = "An office desk with exactly a mug and a book and nothing else"
# Where tests leave what the judges are asked about; not the target directory, of which they do not know.
LEFT = ROOT / "target"
# Steps in their order.
ORDER = (
    # Those that answer within seconds come first.
    "architecture", "formatting", "Python lints", "Python", "dependencies",
    "clippy", "documentation", "cargo test", "programs",
    "words", "sample scenes", "judges' environment",
)
# Those that follow run in two lanes beside each other: most of them keep one core busy.
LANE = ("judges", "judges' own test", "edits", "segmentation sidecar")
LANE_BESIDE = (
    "documents", "robot and episodes", "rest in simulators", "categories", "layers of USD", "Python client", "page",
    "killed while models are asked", "killed on both stores", "tenants",
)
WAIT = "wait for the other lane"


def main() -> int:
    parser = argparse.ArgumentParser(description="Run every test.")
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    parser.add_argument("--only", action="append", metavar="STEP", help="run this step alone, after what it needs was run")
    given = parser.parse_args()
    target = given.target_dir.resolve()
    setup = start_setup(target / "judges")
    try:
        steps = steps_of(target, setup)
        if unknown := [name for name in given.only or () if name not in steps]:
            parser.error(f"no step {', '.join(unknown)}; steps are {', '.join(steps)}")
        return run_all(steps, target) if given.only is None else run_only(steps, given.only, target)
    finally:
        if setup.poll() is None:
            setup.terminate()
            setup.wait()


def steps_of(target: Path, setup: subprocess.Popen) -> dict:
    """What each step does, by name; each gives a sentence or raises a `Problem`."""
    environment = target / "judges"

    def finish_environment():
        # It comes over the network while the compiler works.
        finish_setup(setup)
        return f"ready, of Python {sys.version_info[0]}.{sys.version_info[1]}"

    return {
        "architecture": lambda: cargo_test("--package", "tabletopgen-tidy"),
        "formatting": lambda: cargo("fmt", "--all", "--check"),
        "Python lints": lambda: lint.check(target),
        "Python": test_package,
        "dependencies": lambda: check_dependencies(target / "tools"),
        "clippy": lambda: cargo("clippy", "--workspace", "--locked", "--all-targets", "--", "-D", "warnings"),
        "documentation": document,
        "cargo test": lambda: with_postgres(target, test_workspace),
        "programs": build_programs,
        "words": lambda: check_words(target),
        "sample scenes": lambda: make_sample(target),
        "judges' environment": finish_environment,
        "judges": lambda: judge_sample(target, environment),
        "judges' own test": lambda: test_judges(target, environment),
        "rest in simulators": lambda: check_rest(target, environment),
        "categories": lambda: check_categories(target),
        "edits": lambda: check_edits(target, environment),
        "robot and episodes": lambda: check_robot(target),
        "documents": lambda: check_documents(target),
        "layers of USD": lambda: judge_layers(environment),
        "killed while models are asked": lambda: check_kills(target),
        "killed on both stores": lambda: check_reliability(target),
        "tenants": lambda: check_tenants(target),
        "segmentation sidecar": lambda: test_sidecar(environment),
        "page": lambda: page.check(target / "debug" / "tabletopgen"),
        "Python client": lambda: client.check(target, target / "debug" / "tabletopgen"),
    }


def run_all(steps: dict, target: Path) -> int:
    lane = [sys.executable, "-m", "tabletopgen_checks.test", "--target-dir", str(target)]
    lane += [word for name in LANE_BESIDE for word in ("--only", name)]
    report, beside = StepReport(target), BackgroundProgram()

    def finish_lane():
        report.take_over(beside.finish())
        return f"{len(LANE_BESIDE)} steps"

    try:
        report.run(steps, ORDER)
        if not report.is_failed:
            beside.start(lane, ROOT)
            # Where a step of the other lane failed, those to come are left out.
            rest = (name for name in (*LANE, WAIT) if name == WAIT or not beside.has_failed())
            report.run({**steps, WAIT: finish_lane}, rest)
    finally:
        beside.stop()
        report.summarize("make test")
    return int(report.is_failed)


def run_only(steps: dict, names: list, target: Path) -> int:
    report = StepReport(target)
    report.run(steps, ["judges' environment", *names])
    return int(report.is_failed)


def run(command, environment=None) -> None:
    """Lets a command speak for itself."""
    code = subprocess.run(
        [str(part) for part in command], cwd=ROOT, env=environment_with(environment), stdin=subprocess.DEVNULL
    ).returncode
    if code != 0:
        raise Problem(ended(command, code))


def streamed(command, environment=None, errors=None, shown=True) -> tuple:
    """The exit code and the lines of a command's output; with `errors`, its errors too. Shown as they come, or not."""
    lines = []
    with subprocess.Popen(
        [str(part) for part in command],
        cwd=ROOT,
        env=environment_with(environment),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=errors,
        text=True,
        errors="replace",
    ) as process:
        for line in process.stdout or ():
            if shown:
                sys.stdout.write(line)
                sys.stdout.flush()
            lines.append(line)
        code = process.wait()
    return code, lines


def said(command, environment=None) -> list:
    """The lines of a command that has to succeed."""
    code, lines = streamed(command, environment)
    if code != 0:
        raise Problem(ended(command, code))
    return lines


def environment_with(more):
    return dict(os.environ, **(more or {}))


def ended(command, code) -> str:
    return f"`{' '.join(map(str, command))}` ended with exit code {code}; see above"


def cargo(*arguments, environment=None) -> str:
    run([CARGO, *arguments], environment)
    return "clean"


def document() -> str:
    flags = f"{os.environ.get('RUSTDOCFLAGS', '')} -D warnings".strip()
    return cargo("doc", "--workspace", "--no-deps", "--locked", environment={"RUSTDOCFLAGS": flags})


def check_dependencies(folder: Path) -> str:
    """deny.toml says what may be there; what is there has to be used."""
    programs = tools.installed(folder)
    run([programs / "cargo-deny", "--locked", "check", "--hide-inclusion-graph", *tools.CHECKS])
    run([programs / "cargo-shear", "--locked"])
    return "allowed and used"


def test_package() -> str:
    folder = Path(__file__).with_name("tests")
    unittest = [sys.executable, "-m", "unittest", "discover", "--buffer"]
    run([*unittest, "--start-directory", folder, "--top-level-directory", PYTHON])
    return "as they should be"


def with_postgres(target: Path, step) -> str:
    """Runs a step beside a private server, unless the environment names one."""
    if postgres.VARIABLE in os.environ:
        return step()
    with postgres.Postgres(target) as server:
        os.environ[postgres.VARIABLE] = server.url()
        try:
            return step()
        finally:
            del os.environ[postgres.VARIABLE]


def cargo_test(*arguments, more=None, shown=True) -> str:
    """What cargo's tests are, as a sentence. What they print is shown as it comes, or else at the end in one piece."""
    # Without an adapter the tests of the GPU kernels fail instead of passing by doing nothing.
    environment = {"TABLETOPGEN_GPU_TESTS": os.environ.get("TABLETOPGEN_GPU_TESTS", "require"), **(more or {})}
    command = [CARGO, "test", "--locked", *arguments]
    # In one stream, so that the program of a failing test is known.
    code, lines = streamed(command, environment, errors=subprocess.STDOUT, shown=shown)
    if not shown:
        sys.stdout.write("".join(lines))
        sys.stdout.flush()
    results = cargo_results.read(lines)
    if code != 0:
        raise Problem(results.complaint() or ended(command, code))
    if results.passed == 0:
        raise Problem("no test ran")
    return results.summary()


def test_workspace() -> str:
    """The integration tests, which wait more than they compute, beside all others."""
    for name in ("usd_layers", "specimen"):
        shutil.rmtree(LEFT / name, ignore_errors=True)
    cargo("test", "--workspace", "--locked", "--no-run")
    with ThreadPoolExecutor(2) as pool:
        lanes = [pool.submit(test_integration), pool.submit(test_units)]
    wrong = [str(lane.exception()) for lane in lanes if isinstance(lane.exception(), Problem)]
    if wrong:
        raise Problem("; ".join(wrong))
    return "; ".join(lane.result() for lane in lanes)


def test_integration() -> str:
    """On SQLite, and those that start servers once more on PostgreSQL. Left out there are those that open the SQLite
    file or expect that a lease in it ends with its process."""
    on_sqlite = cargo_test("--workspace", "--no-fail-fast", "--test", "it", shown=False)
    tests = ("api::", "worker::lifecycle", "worker::drain", "worker::single_flight")
    postgres_too = {"TABLETOPGEN_TEST_DATABASE": "postgres"}
    asked = ("--workspace", "--no-fail-fast", "--test", "it", "--", *tests)
    return f"integration {on_sqlite}; on PostgreSQL {cargo_test(*asked, more=postgres_too, shown=False)}"


def test_units() -> str:
    # Every test program but those named `it`: names of another first letter, and longer ones of this.
    programs = ("--lib", "--bins", "--test", "[!i]*", "--test", "i??*")
    units = cargo_test("--workspace", "--no-fail-fast", *programs)
    return f"others {units}; in documentation {cargo_test('--workspace', '--no-fail-fast', '--doc')}"


def build_programs() -> str:
    """A program that no integration test starts is not there yet. With the tests named, nothing is compiled twice."""
    cargo("build", "--workspace", "--locked", "--bins", "--tests", "--examples")
    return "built"


def check_kills(target: Path) -> str:
    """A few of the kills of `make bars BARS=remote_kill`."""
    command = [sys.executable, "-m", "tabletopgen_checks.bars.remote_kill", "--target-dir", target, "--kills", KILLS, "--draw", "2"]
    run([*command, "--program", target / "debug" / "tabletopgen"])
    return f"{KILLS} kills, nothing billed twice that is not in the ledger"


def check_reliability(target: Path) -> str:
    """A few of the kills of `make bars BARS=reliability`, on SQLite and on a private PostgreSQL with a private S3."""
    command = [sys.executable, "-m", "tabletopgen_checks.bars.reliability", "--target-dir", target, "--page", "no", *RELIABILITY]
    run([*command, "--program", target / "debug" / "tabletopgen"])
    return "nothing lost, repeated or committed twice; identical requests make one scene"


def check_tenants(target: Path) -> str:
    """Parts of the bar of tenants: what is deleted goes, secrets are nowhere."""
    command = [sys.executable, "-m", "tabletopgen_checks.bars.tenants", "--target-dir", target, "--page", "no", *TENANTS]
    run([*command, "--uncommitted", "--program", target / "debug" / "tabletopgen"])
    return "deletion leaves nothing, no secret is shown"


def test_sidecar(environment: Path) -> str:
    """The protocol of docker/grounded-sam2, with a model that finds a square."""
    folder = ROOT / "docker/grounded-sam2"
    run([environment / "bin/python", "-m", "unittest", "discover", "--start-directory", folder, "--top-level-directory", folder])
    return "answers its protocol"


def judge_layers(environment: Path) -> str:
    """What a test left: random layers in both forms, and one bundle in each form of USD."""
    python = environment / "bin/python"
    lines = said([python, JUDGES / "usd_layers.py", LEFT / "usd_layers"])
    bundles = [LEFT / "specimen" / form for form in ("usda", "usdc", "usdz")]
    run([python, JUDGES / "judge.py", "--only", "schema,usd,robotics_prop,marks,readme", *bundles])
    return lines[-1].strip()


def check_words(target: Path) -> str:
    programs, folder = target / "debug", target / "words"
    # Scenes of an earlier run would be taken for those of this one.
    shutil.rmtree(folder, ignore_errors=True)
    return words_sample.check(programs / "tabletopgen-lab", programs / "tabletopgen", folder)


def check_edits(target: Path, environment: Path) -> str:
    programs, folder = target / "debug", target / "edits"
    # Scenes of an earlier run would be taken for those of this one.
    shutil.rmtree(folder, ignore_errors=True)
    return edit_sample.check(programs / "tabletopgen-lab", programs / "tabletopgen", folder, environment)


def check_rest(target: Path, environment: Path) -> str:
    """A few scenes and programs of `make bars BARS=rest`."""
    return rest_sample.check(target / "debug" / "tabletopgen", target / "rest_sample", environment)


def check_categories(target: Path) -> str:
    """The scenes of `make bars BARS=categories` that once were not certified."""
    command = [sys.executable, "-m", "tabletopgen_checks.bars.categories", "--target-dir", target, "--part", "sample"]
    run([*command, "--uncommitted", "--program", target / "debug" / "tabletopgen"])
    return "certified"


def check_documents(target: Path) -> str:
    """The fences of README and tutorial but the slow ones; `python3 -m tabletopgen_checks.documents` runs them all, and
    those of the guide, which take many minutes."""
    return documented.check(target / "debug" / "tabletopgen", documented.GROUPS[:1])


def check_robot(target: Path) -> str:
    return robot_sample.check(target / "debug" / "tabletopgen", target / "robot_sample", target)


def make_sample(target: Path) -> str:
    # The development build is optimized and there already; building for release would take longer.
    binary = target / "debug" / "tabletopgen"
    wanted = [(sample_folder(target, sentence), sentence.text, sentence.seed, 1) for sentence in chosen()]
    wanted += [(folder_of_threads(target, s), s.text, s.seed, 2) for s in chosen() if s.threads]
    wanted.append((small_folder(target), SMALL_SCENE, 1, 1))
    slowest, made = 0.0, {}
    with ThreadPoolExecutor(2) as pool:
        for scene in pool.map(lambda one: generate(binary, *one[:3], threads=one[3]), wanted):
            made[scene.folder] = scene
    for sentence in chosen():
        scene = made[sample_folder(target, sentence)]
        slowest = max(slowest, scene.seconds)
        wrong = sentence.complaints(read_scene(scene.folder)) + scene.printed["reasons"]
        print(f"   {sentence.name}: {sentence.objects} objects in {scene.seconds:.1f} s {'; '.join(wrong)}", flush=True)
        if wrong:
            raise Problem(f"{sentence.name}: {'; '.join(wrong)}")
        if sentence.threads:
            if differing := differing_files(scene.folder, folder_of_threads(target, sentence)):
                raise Problem(f"one thread and two give other bytes: {', '.join(differing[:10])}")
            print(f"   {sentence.name}: the same bytes with one thread and with two", flush=True)
    return f"{len(chosen())} scenes as asked for, two at once, the slowest in {slowest:.1f} s"


def chosen():
    return [sentence for sentence in sentences() if sentence.sample]


def sample_folder(target: Path, sentence) -> Path:
    return target / "sample" / sentence.name


def folder_of_threads(target: Path, sentence) -> Path:
    return target / "sample_of_two_threads" / sentence.name


def small_folder(target: Path) -> Path:
    return target / "sample_small" / "mug_and_book"


def judge_sample(target: Path, environment: Path) -> str:
    bundles = [sample_folder(target, sentence) for sentence in chosen()]
    # NVIDIA's judges take a second a prop: they see the layers a test left and the small scene, in other steps.
    fully = [name for name in JUDGE_NAMES if name != "robotics_prop"]
    briefly = [name for name in fully if name != "readme"]
    quickly = [name for name in briefly if name not in SLOW_JUDGES]
    longer, others = bundles[:JUDGED_LONGER], bundles[JUDGED_LONGER:]
    findings = judge_beside(environment, [
        {"bundles": longer, "only": fully, "slow_seconds": SLOW_SECONDS_LONGER},
        {"bundles": others[:JUDGED_BRIEFLY], "only": briefly, "slow_seconds": SLOW_SECONDS},
        {"bundles": others[JUDGED_BRIEFLY:], "only": quickly},
    ])
    for bundle in bundles:
        verdicts = findings["bundles"][str(bundle.resolve())]
        words = [f"{name} {v['facts'].get('seconds', 0):.1f} s" for name, v in verdicts.items()]
        print(f"   {bundle.name}: {', '.join(words)}", flush=True)
        for complaint in complaints(findings, bundle)[:20]:
            print(f"     - {complaint}", flush=True)
    if not findings["accepted"]:
        raise Problem(f"not every judge accepts, or too few bodies rest ({findings['dss_mujoco']:.3f} of them)")
    words_of_all = f"all accept {len(bundles)} bundles; in MuJoCo {100 * findings['dss_mujoco']:.1f} % rest"
    return "; ".join([words_of_all] + [f"LEFT OUT: {name} ({why})" for name, why in findings["left_out"].items()])


def test_judges(target: Path, environment: Path) -> str:
    lines = said([environment / "bin/python", JUDGES / "test_judges.py", small_folder(target)])
    return lines[-1].strip() if lines else "silent"


if __name__ == "__main__":
    sys.exit(main())
