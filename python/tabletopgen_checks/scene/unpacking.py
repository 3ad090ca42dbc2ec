"""Unpacks a downloaded bundle and prints its certificate. Standard library only."""

import json
import os
import shutil
import zipfile
from pathlib import Path

from tabletopgen_checks.problem import Problem


def unpack(archive: Path, folder: Path) -> Path:
    """Writes the bundle's files to `folder`, without the archive's one top folder; replaces an old bundle."""
    if foreign := files_of_others(folder):
        raise Problem(f"{folder} holds {foreign[0]}, which is no file of a bundle of an earlier run; move it away")
    fresh = folder.with_name(folder.name + ".part")
    shutil.rmtree(fresh, ignore_errors=True)
    with zipfile.ZipFile(archive) as bundle:
        for entry in bundle.infolist():
            _, _, inner = entry.filename.partition("/")
            if entry.is_dir() or not inner:
                continue
            target = fresh / inner
            if os.path.isabs(inner) or ".." in Path(inner).parts:
                raise Problem(f"{archive} holds a file that would land outside: {entry.filename}")
            target.parent.mkdir(parents=True, exist_ok=True)
            with bundle.open(entry) as source, open(target, "wb") as out:
                shutil.copyfileobj(source, out)
    if folder.exists():
        shutil.rmtree(folder)
    fresh.rename(folder)
    return folder


def files_of_others(folder: Path) -> list:
    """Files in a folder that the manifest of a bundle there does not list; all where there is no bundle."""
    if not folder.exists():
        return []
    try:
        manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
        listed = {"manifest.json", *(file["path"] for file in manifest["files"])}
    except (OSError, ValueError, KeyError, TypeError):
        listed = set()
    found = (path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir())
    return sorted(path for path in found if path not in listed)


def percent(fraction) -> str:
    return f"{100 * fraction:.1f} %"


def print_certificate(folder: Path):
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    scene = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    metrics = report["metrics"]
    print(f"  verdict          {report['verdict']}")
    for reason in report.get("reasons", []):
        print(f"                   {reason['sentence']}")
    objects = len(scene["instances"])
    print(f"  objects          {objects} on a {scene['table']['label']} ({scene['table']['shape']})")
    print(f"  Col_O            {percent(metrics['col_o'])} of pairs collide")
    print(f"  SS               {percent(metrics['ss'])} of objects are supported")
    print(f"  DSS as aligned   {percent(metrics['dss_aligned'])} stay where alignment put them, 5 s under gravity")
    print(f"  DSS as shipped   {percent(metrics['dss_shipped'])} stay where the bundle puts them, 5 s under gravity")
    print(f"  {'name':<24} {'mass':>9} {'on':<20} {'moved by settle':>16}")
    moved = {o["name"]: o["moved"]["by_settling"]["distance_m"] for o in report.get("objects", [])}
    for instance in scene["instances"]:
        name = instance["name"]
        shift = f"{1e3 * moved[name]:.2f} mm" if name in moved else "-"
        print(f"  {name:<24} {instance['mass_kg']:>6.3f} kg {instance['support']['parent']:<20} {shift:>16}")
