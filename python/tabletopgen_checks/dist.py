"""The program packed for people without a compiler, with what its licenses ask for and what is in it.

    PYTHONPATH=python python3 -m tabletopgen_checks.dist [--target-dir target] [--program target/release/tabletopgen]

TARGET/dist gets tabletopgen-VERSION-TRIPLE.tar.gz (program, manual, completions, license texts, bill of materials) and
SHA256SUMS. The same commit and program give the same bytes. The archive is unpacked and tried before it is named.
"""

import argparse
import gzip
import hashlib
import io
import json
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import uuid
from pathlib import Path

from tabletopgen_checks.problem import Problem
from tabletopgen_checks.repository import ROOT

CARGO = os.environ.get("CARGO", "cargo")
SHELLS = {"bash": "tabletopgen.bash", "zsh": "_tabletopgen", "fish": "tabletopgen.fish"}
LICENSE_FILES = re.compile(r"(?i)(licen[sc]e|copying|notice|unlicense|copyright)")
# Files of the repository that go along.
DOCUMENTS = ("README.md", "LICENSE", "NOTICE", "CHANGELOG.md")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target-dir", type=Path, default=ROOT / "target")
    parser.add_argument("--program", type=Path)
    given = parser.parse_args()
    target = given.target_dir.resolve()
    print(made(given.program or target / "release" / "tabletopgen", target / "dist"))
    return 0


def made(program: Path, folder: Path) -> str:
    """Packs the program; a sentence about the archive."""
    version, triple = said(program, "--version").split()[1], triple_of_host()
    name = f"tabletopgen-{version}-{triple}"
    crates = linked_crates(triple)
    files = {"tabletopgen": (without_symbols(program, folder).read_bytes(), 0o755)}
    for document in DOCUMENTS:
        files[document] = (ROOT / document).read_bytes(), 0o644
    for shell, file in SHELLS.items():
        files[f"completions/{file}"] = said(program, "completions", shell).encode(), 0o644
    with tempfile.TemporaryDirectory() as manual:
        said(program, "man", "--out", manual)
        for page in sorted(Path(manual).iterdir()):
            files[f"man/man1/{page.name}"] = page.read_bytes(), 0o644
    files["THIRD_PARTY_LICENSES.txt"] = license_texts(crates).encode(), 0o644
    files["sbom.cdx.json"] = bill_of_materials(version, crates).encode(), 0o644
    archive = folder / f"{name}.tar.gz"
    archive.write_bytes(packed(name, files))
    digest = hashlib.sha256(archive.read_bytes()).hexdigest()
    (folder / "SHA256SUMS").write_text(f"{digest}  {archive.name}\n", encoding="utf-8")
    tried = try_archive(archive, name)
    size = archive.stat().st_size / 1e6
    return f"{archive} ({size:.1f} MB, {len(crates)} crates, {needed_libraries(program)}): {tried}"


def without_symbols(program: Path, folder: Path) -> Path:
    """A copy in a folder. A panic names file and line without symbols, which are a fifth of the program."""
    folder.mkdir(parents=True, exist_ok=True)
    copy = folder / "tabletopgen"
    # A copy that runs cannot be written to.
    copy.unlink(missing_ok=True)
    said(Path("strip"), "--strip-all", "-o", copy, program)
    return copy


def said(program: Path, *arguments) -> str:
    command = [str(program), *map(str, arguments)]
    ran = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if ran.returncode != 0:
        raise Problem(f"`{' '.join(command)}` ended with exit code {ran.returncode}: {ran.stderr.strip()}")
    return ran.stdout


def triple_of_host() -> str:
    rustc = os.environ.get("RUSTC", "rustc")
    return next(line.split()[1] for line in said(Path(rustc), "-vV").splitlines() if line.startswith("host:"))


def linked_crates(triple: str) -> list:
    """The packages of the registry that are linked into the program, by name and version."""
    command = [CARGO, "metadata", "--format-version", "1", "--locked", "--filter-platform", triple]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout)
    packages = {package["id"]: package for package in metadata["packages"]}
    needs = {
        node["id"]: [d["pkg"] for d in node["deps"] if any(kind["kind"] is None for kind in d["dep_kinds"])]
        for node in metadata["resolve"]["nodes"]
    }
    found, waiting = set(), [id for id, package in packages.items() if package["name"] == "tabletopgen"]
    while waiting:
        id = waiting.pop()
        if id not in found:
            found.add(id)
            waiting += needs[id]
    crates = [packages[id] for id in found if packages[id]["source"]]
    return sorted(crates, key=lambda crate: (crate["name"], crate["version"]))


def license_texts(crates: list) -> str:
    """The texts that the crates come with, each once, with the crates that it is of."""
    texts, without = {}, []
    for crate in crates:
        files = license_files(Path(crate["manifest_path"]).parent)
        if not files:
            without.append(crate)
        for file in files:
            text = file.read_text(encoding="utf-8", errors="replace").strip()
            texts.setdefault(text, []).append(title(crate))
    parts = [f"Of {', '.join(sorted(set(names)))}:\n\n{text}" for text, names in texts.items()]
    for crate in without:
        of = ", ".join(crate["authors"]) or f"the authors of {crate['name']}"
        parts.append(f"{title(crate)} comes without a text. It is under {crate['license']}, copyright {of}, {crate['repository']}.")
    line = "\n\n" + 100 * "-" + "\n\n"
    return "The program contains these packages, under these licenses.\n" + line + line.join(parts) + "\n"


def license_files(folder: Path) -> list:
    """Those of the package itself, or else those of the sources that it contains."""
    for depth in ("*", "*/*"):
        files = sorted(path for path in folder.glob(depth) if LICENSE_FILES.match(path.name) and path.is_file())
        if files:
            return files
    return []


def title(crate: dict) -> str:
    return f"{crate['name']} {crate['version']} ({crate['license'] or 'see below'})"


def bill_of_materials(version: str, crates: list) -> str:
    """CycloneDX 1.6, JSON."""
    components = [
        {
            "type": "library",
            "bom-ref": purl(crate),
            "name": crate["name"],
            "version": crate["version"],
            "purl": purl(crate),
            # Older crates write a slash where SPDX has OR.
            "licenses": [{"expression": re.sub(r"\s*/\s*", " OR ", crate["license"])}] if crate["license"] else [],
            "description": (crate["description"] or "").strip(),
        }
        for crate in crates
    ] + page_components()
    document = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        # Of the content, so that the same program has the same number.
        "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, ' '.join(map(purl, crates)))}",
        "version": 1,
        "metadata": {"component": {"type": "application", "bom-ref": "tabletopgen", "name": "tabletopgen", "version": version}},
        "components": components,
        "dependencies": [{"ref": "tabletopgen", "dependsOn": [part["bom-ref"] for part in components]}],
    }
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def page_components() -> list:
    """The packages of npm that the page in the program is made of; their license texts are among its files."""
    lock = json.loads((ROOT / "studio" / "package-lock.json").read_text(encoding="utf-8"))
    packages = {path.removeprefix("node_modules/"): about for path, about in lock["packages"].items() if path}
    return [
        {
            "type": "library",
            "bom-ref": (ref := f"pkg:npm/{name.replace('@', '%40')}@{about['version']}"),
            "name": name,
            "version": about["version"],
            "purl": ref,
            "licenses": [{"expression": about["license"]}],
        }
        for name, about in sorted(packages.items())
        if not about.get("dev")
    ]


def purl(crate: dict) -> str:
    return f"pkg:cargo/{crate['name']}@{crate['version'].replace('+', '%2B')}"


def packed(name: str, files: dict) -> bytes:
    """A tar.gz of files below one folder, whose times are those of the commit."""
    at = int(said(Path("git"), "-C", ROOT, "log", "-1", "--format=%ct"))
    buffer = io.BytesIO()
    with gzip.GzipFile(fileobj=buffer, mode="wb", mtime=0) as zipped, tarfile.open(fileobj=zipped, mode="w") as archive:
        for path in sorted(files):
            content, mode = files[path]
            entry = tarfile.TarInfo(f"{name}/{path}")
            entry.size, entry.mode, entry.mtime = len(content), mode, at
            archive.addfile(entry, io.BytesIO(content))
    return buffer.getvalue()


def try_archive(archive: Path, name: str) -> str:
    """Unpacks it elsewhere and lets its program check itself, with an empty environment."""
    with tempfile.TemporaryDirectory() as folder:
        with tarfile.open(archive) as tar:
            tar.extractall(folder, filter="data")
        program = Path(folder) / name / "tabletopgen"
        command, variables = [str(program), "doctor", "--json"], {"HOME": folder, "PATH": "/usr/bin:/bin"}
        ran = subprocess.run(command, cwd=folder, env=variables, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        checks = {check["check"]: check for check in json.loads(ran.stdout)["checks"]}
        if checks["scene"]["state"] != "ok":
            raise Problem(f"the program of {archive} made no scene: {checks['scene']['detail']}")
        return f"unpacked, it made {checks['scene']['detail']}"


def needed_libraries(program: Path) -> str:
    """What the program wants of the system."""
    lines = said(Path("readelf"), "--dynamic", "--wide", program).splitlines()
    libraries = [match[1] for line in lines if (match := re.search(r"NEEDED.*\[(.*)\]", line))]
    versions = set(re.findall(r"GLIBC_(\d+)\.(\d+)", said(Path("readelf"), "--version-info", "--wide", program)))
    newest = max((int(major), int(minor)) for major, minor in versions)
    return f"links {', '.join(libraries)}; glibc {newest[0]}.{newest[1]} or later"


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Problem as problem:
        sys.exit(str(problem))
