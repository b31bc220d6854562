#!/usr/bin/env python3
"""The parts of the program as a list in CycloneDX 1.6: `cargo metadata … | parts.py SECONDS`, the date in seconds since
1970. These are the crates that are linked into it, those that are C inside with what they carry, and who uses whom.
"""
import json, re, sys, uuid
from datetime import datetime, timezone
from pathlib import Path

# What some crates carry: its name, the licence, and where its version is, as one or several numbers.
CARRIED = {
    "libsqlite3-sys": ("SQLite", {"license": {"name": "public domain"}}, "sqlite3/sqlite3.h", r'SQLITE_VERSION\s+"([\d.]+)"'),
    "rquickjs-sys": ("QuickJS-ng", {"expression": "MIT"}, "quickjs/quickjs.h", r"QJS_VERSION_(?:MAJOR|MINOR|PATCH)\s+(\d+)"),
}

metadata = json.load(sys.stdin)
packages = {package["id"]: package for package in metadata["packages"]}
nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
reference = lambda package: f"pkg:cargo/{package['name']}@{package['version']}"


def linked(node):
    """The crates that a crate is linked with: not those that only its build or its tests use, nor macros."""
    normal = [dep["pkg"] for dep in node["deps"] if any(kind["kind"] is None for kind in dep["dep_kinds"])]
    return [package for package in normal if "proc-macro" not in str(packages[package]["targets"])]


def component(package):
    part = {"type": "library", "bom-ref": reference(package), "purl": reference(package), "name": package["name"],
            "version": package["version"], "licenses": [{"expression": (package["license"] or "").replace("/", " OR ")}]}
    if not package["source"]:
        # It is not on an index.
        del part["purl"]
    if package["name"] in CARRIED:
        name, licence, file, pattern = CARRIED[package["name"]]
        version = ".".join(re.findall(pattern, (Path(package["manifest_path"]).parent / file).read_text())[:3])
        part["components"] = [{"type": "library", "bom-ref": name, "name": name, "version": version, "licenses": [licence]}]
    return part


[root] = [package for package in metadata["packages"] if package["name"] == "steward"]
reached, ahead = set(), [root["id"]]
while ahead:
    one = ahead.pop()
    if one not in reached:
        reached.add(one)
        ahead += linked(nodes[one])
ordered = sorted(reached - {root["id"]}, key=lambda one: (packages[one]["name"], packages[one]["version"]))
uses = [{"ref": reference(packages[one]), "dependsOn": sorted({reference(packages[other]) for other in linked(nodes[one])})}
        for one in [root["id"], *ordered]]
date = datetime.fromtimestamp(int(sys.argv[1]), timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
parts = [component(packages[one]) for one in ordered]
content = {"component": {**component(root), "type": "application"}, "parts": parts, "uses": uses}
serial = uuid.uuid5(uuid.NAMESPACE_URL, json.dumps(content))
print(json.dumps({
    "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json", "bomFormat": "CycloneDX", "specVersion": "1.6",
    "serialNumber": f"urn:uuid:{serial}", "version": 1,
    "metadata": {"timestamp": date, "component": content["component"]}, "components": parts, "dependencies": uses,
}, indent=1))
