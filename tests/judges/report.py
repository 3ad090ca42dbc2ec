"""report.json fits its schema and agrees with scene.json; report.html is strict HTML that stands alone."""

import json
import unicodedata
from pathlib import Path

import html5lib
import jsonschema

from verdict import Verdict, bodies, read_scene


def judge(bundle: Path) -> Verdict:
    verdict = Verdict("report")
    report = json.loads((bundle / "report.json").read_text(encoding="utf-8"))
    schema = json.loads((bundle / "report.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    for error in jsonschema.Draft202012Validator(schema).iter_errors(report):
        verdict.complaints.append(f"report.json at {error.json_path}: {error.message[:200]}")
    scene = read_scene(bundle)
    if (report["scene"], report["seed"], report["metrics"]) != (scene["id"], scene["seed"], scene["metrics"]):
        verdict.complaints.append("report.json tells of another scene than scene.json")
    if [b["name"] for b in report["bodies"]] != [b["name"] for b in bodies(scene)]:
        verdict.complaints.append("report.json and scene.json tell different bodies")
    if (report["verdict"] == "pass") != (not report["reasons"]):
        verdict.complaints.append(f"{report['verdict']} with {len(report['reasons'])} reasons")
    path = bundle / "report.html"
    page = path.read_bytes()
    verdict.complaints += page_complaints(page.decode("utf-8"), report, scene)
    verdict.facts = {"reasons": len(report["reasons"]), "page_kb": round(len(page) / 1e3)}
    return verdict


def page_complaints(text, report, scene):
    parser = html5lib.HTMLParser(namespaceHTMLElements=False)
    tree = parser.parse(text)
    complaints = [f"report.html at {place}: {code} {details}" for place, code, details in parser.errors]
    ids = [element.get("id") for element in tree.iter() if element.get("id")]
    if len(set(ids)) != len(ids):
        complaints.append("report.html uses an id twice")
    for element in tree.iter():
        for name, value in element.attrib.items():
            outside = name in ("src", "href", "srcset", "data", "action") and not value.startswith(("#", "data:image/"))
            if outside or name.startswith("on"):
                complaints.append(f"report.html: {element.tag} {name}={value[:60]!r} leads outside the page")
            if name == "href" and value.startswith("#") and value[1:] not in ids:
                complaints.append(f"report.html: nothing is called {value!r}")
    if any(tree.iter("script")) or any(tree.iter("link")):
        complaints.append("report.html runs or fetches something")
    words = "".join(tree.itertext())
    expected = [report["verdict"], report["summary"], scene["id"]] + [reason["sentence"] for reason in report["reasons"]]
    expected += [instance["label"] for instance in scene["instances"]]
    complaints += [f"report.html does not tell {what!r}" for what in map(shown, expected) if what not in words]
    return complaints


def shown(words):
    """A page has no way to hold most control characters."""
    return "".join("\ufffd" if unicodedata.category(c) == "Cc" and c not in "\n\r\t" else c for c in words)
