#!/usr/bin/env python3
"""What CI systems get: the files of `--results`, read by other programs, and the steps of action.yml.

Usage: ci_results.py STEWARD SARIF_SCHEMA. Needs PyYAML, jsonschema, check-jsonschema, markdown-it-py and
sarif-tools. The schema is that
of a package, such as @microsoft/jest-sarif.
"""

import hashlib
import http.server
import io
import json
import os
import re
import subprocess
import sys
import tarfile
import tempfile
import threading
import xml.etree.ElementTree
import zipfile
from pathlib import Path

import jsonschema
import yaml
from markdown_it import MarkdownIt

ROOT = Path(__file__).resolve().parent.parent
STEWARD = Path(sys.argv[1]).resolve()
SCHEMA = jsonschema.validators.validator_for(schema := json.loads(Path(sys.argv[2]).read_text()))(schema)
SCRIPTS = Path(sys.executable).parent

WRONG_PROPERTY = "// grün 𝄞\nproperty p := always (BatteryReader, BatteryLevl, m[2] > 1)\n"
LOW = """// The level | is `never` <b>below</b> 90 %.
property never_low := always ((BatteryReader, BatteryLevel, m[1] = <ok>) implies
  (BatteryReader, BatteryLevel, m[2] >= 90))
"""


def results(folder, name, status, *arguments):
    """Runs a command with all three formats, and returns the contents of the SARIF file's run, of JUnit and Markdown."""
    files = [f"results/{name}.{ending}" for ending in ("sarif", "xml", "md")]
    to = [word for file in files for word in ("--results", file)]
    done = subprocess.run([STEWARD, *arguments, *to], cwd=folder, capture_output=True, text=True, timeout=300)
    assert done.returncode == status, (arguments, done.returncode, done.stdout, done.stderr)
    sarif, junit, markdown = [Path(folder, file).read_text(encoding="utf-8") for file in files]
    return check_sarif(json.loads(sarif), folder), check_junit(junit), check_markdown(markdown, folder)


def check_sarif(log, folder):
    """The schema, and what it cannot say: that each result is where it claims to be."""
    SCHEMA.validate(log)
    [run] = log["runs"]
    assert run["columnKind"] == "unicodeCodePoints"
    prints = [result["partialFingerprints"]["steward/v1"] for result in run["results"]]
    assert len(set(prints)) == len(prints), prints
    for result in run["results"]:
        assert run["tool"]["driver"]["rules"][result["ruleIndex"]]["id"] == result["ruleId"]
        steps = [step["location"] for flow in result.get("codeFlows", []) for thread in flow["threadFlows"]
                 for step in thread["locations"]]
        for location in result["locations"] + steps:
            place = location["physicalLocation"]
            address, region = place["artifactLocation"], place["region"]
            if address.get("uriBaseId") != "%SRCROOT%" or "startColumn" not in region:
                continue
            text = Path(folder, address["uri"]).read_bytes().decode()
            before = text[: region["charOffset"]]
            marked = text[region["charOffset"] : region["charOffset"] + region["charLength"]]
            # Readers in JavaScript count UTF-16 code units, editors lines and columns: all must agree.
            assert region["startLine"] == before.count("\n") + 1, region
            assert region["startColumn"] == len(before.rsplit("\n", 1)[-1]) + 1, region
            end = before + marked
            assert region["endLine"] == end.count("\n") + 1, region
            assert region["endColumn"] == len(end.rsplit("\n", 1)[-1]) + 1, region
            location["marked"] = marked
    return run


def check_junit(text):
    return xml.etree.ElementTree.fromstring(text)


def check_markdown(text, folder):
    """Rendered by another program: a table with the same number of cells in each row, no HTML from files, no dead
    links."""
    html = MarkdownIt("commonmark", {"html": True}).enable("table").render(text)
    tree = xml.etree.ElementTree.fromstring("<page>" + html.replace("&nbsp;", " ").replace("<br>", "<br/>") + "</page>")
    rows = [len(row) for row in tree.iter("tr")]
    assert rows and set(rows) == {4}, rows
    tags = {element.tag for element in tree.iter()}
    known = {"page", "h1", "h2", "h3", "p", "table", "thead", "tbody", "tr", "th", "td", "strong", "code", "a", "ul",
             "ol", "li", "br", "br/"}
    assert tags <= known, tags - known
    for link in tree.iter("a"):
        target = Path(folder, "results", link.get("href").replace("%20", " "))
        assert target.exists(), f"a dead link to {target}"
    return tree


def text_of(tree):
    return " ".join("".join(tree.itertext()).split())


def rules(run):
    return sorted((result["ruleId"], result["level"]) for result in run["results"])


def commands(folder):
    """All commands, with every kind of result."""
    steward = lambda *words: subprocess.run([STEWARD, *words], cwd=folder, check=True, capture_output=True)
    steward("init", "robot")
    Path(folder, "robot/low.scope").write_text(LOW, encoding="utf-8")
    Path(folder, "wrong.scope").write_text(WRONG_PROPERTY, encoding="utf-8")
    scenario = "robot/battery_fault.toml"
    bare = ["--no-snapshots", "--quiet"]

    run, junit, page = results(folder, "checked", 0, "check", scenario)
    assert run["results"] == [] and junit.get("failures") == "0", run["results"]
    assert "no problems found" in text_of(page)

    run, junit, page = results(folder, "wrong", 2, "check", scenario, "wrong.scope", "missing.toml")
    errors = [result for result in run["results"] if result["ruleId"] == "file-error"]
    [at] = [result["locations"][0] for result in errors if "BatteryLevl" in result["message"]["text"]]
    assert "BatteryLevl" in at["marked"] and at["physicalLocation"]["region"]["startLine"] == 2, at
    # It has no place.
    [invocation] = run["invocations"]
    notifications = [told["message"]["text"] for told in invocation["toolExecutionNotifications"]]
    assert not invocation["executionSuccessful"] and any("missing.toml" in told for told in notifications), invocation
    assert (junit.get("tests"), junit.get("failures"), junit.get("errors")) == ("3", "1", "1"), junit.attrib

    run, junit, page = results(folder, "run", 0, "run", scenario, *bare)
    assert run["results"] == [] and junit.get("failures") == "0"
    assert "Required:" in text_of(page), "an expected violation has a story, too"

    low = ["--set", 'properties=["robot/low.scope"]', "--set", "expect={}"]
    run, junit, page = results(folder, "violated", 1, "run", scenario, "--quiet", *low)
    [violated] = [result for result in run["results"] if result["ruleId"] == "property/never_low"]
    assert violated["locations"][0]["marked"] == "never_low"
    assert violated["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] == "robot/low.scope"
    steps = violated["codeFlows"][0]["threadFlows"][0]["locations"]
    uris = [step["location"]["physicalLocation"]["artifactLocation"]["uri"] for step in steps]
    assert any(uri.endswith(".xml") for uri in uris) and uris[-1] == "robot/low.scope", uris
    assert "The level | is `never` <b>below</b> 90 %" in text_of(page) or "<b>below</b> 90 %" in text_of(page), text_of(page)
    assert any(link.get("href").endswith(".png") for link in page.iter("a"))

    # Only what happened decides a fingerprint, and not where it is written.
    before = violated["partialFingerprints"]
    Path(folder, "robot/low.scope").write_text("\n\n" + LOW, encoding="utf-8")
    run, _, _ = results(folder, "moved", 1, "run", scenario, *bare, *low)
    [moved] = [result for result in run["results"] if result["ruleId"] == "property/never_low"]
    assert moved["partialFingerprints"] == before
    assert moved["locations"] != violated["locations"]

    run, junit, _ = results(folder, "refused", 2, "run", scenario, "--set", "battery.initial_pct=900")
    assert rules(run) == [("file-error", "error")] or run["invocations"][0]["toolExecutionNotifications"], run
    assert junit.get("errors") == "1" and not run["invocations"][0]["executionSuccessful"]
    run, junit, _ = results(folder, "unknown", 2, "run", "no_such_scenario")
    [note] = run["invocations"][0]["toolExecutionNotifications"]
    assert "no_such_scenario" in note["message"]["text"] and junit.get("errors") == "1"

    steward("run", scenario, *bare, "--record", "run.jsonl")
    run, junit, _ = results(folder, "verified", 1, "verify", "run.jsonl", "--scenario", scenario, "--property", "robot/low.scope")
    assert rules(run) == [("property/never_low", "error")], rules(run)
    assert run["results"][0]["locations"][0]["marked"] == "never_low"
    run, _, _ = results(folder, "satisfied", 0, "verify", "run.jsonl", "--scenario", scenario, "--property", "phi2")
    assert run["results"] == []
    run, junit, _ = results(folder, "unreadable", 2, "verify", "missing.jsonl", "--property", "phi2")
    assert junit.get("errors") == "1" and not run["invocations"][0]["executionSuccessful"]

    run, junit, _ = results(folder, "proved", 1, "prove", "nominal", "--quiet", "--property", "phi2", "--property",
                            "phi1", "--set", "prove.expect.phi1=violated", "--unreached")
    assert ("property/phi1", "error") in rules(run) and ("property/phi2", "error") not in rules(run), rules(run)
    run, junit, _ = results(folder, "undecided", 1, "prove", "nominal", "--quiet", "--property", "phi2", "--states", "10")
    assert rules(run) == [("property/phi2", "error")] and "not decided" in run["results"][0]["message"]["text"]

    Path(folder, "many.toml").write_text(f'scenario = "{scenario}"\nruns = 2\n', encoding="utf-8")
    run, junit, _ = results(folder, "campaign", 0, "campaign", "many.toml", "--quiet")
    assert ("violation-rate", "note") in rules(run) and junit.get("failures") == "0", rules(run)

    run, junit, page = results(folder, "matrix", 0, "matrix", scenario, "--fault-free", "nominal", "--runs", "2", "--quiet")
    assert "which it detects" in text_of(page), text_of(page)


def foreign_readers(folder):
    """sarif-tools reads all of them."""
    for words in (["summary"], ["ls"], ["csv", "--output", "all.csv"]):
        done = subprocess.run([SCRIPTS / "sarif", *words, "results"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, (words, done.stdout, done.stderr)
        if words == ["summary"]:
            assert "error" in done.stdout and "property/never_low" in done.stdout, done.stdout


class Runner:
    """Runs the steps of a composite action, as far as they are shell code, as GitHub's runner does."""

    def __init__(self, folder, **inputs):
        self.action = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))
        declared = self.action["inputs"]
        assert set(inputs) <= set(declared), inputs
        self.inputs = {name: inputs.get(name, about["default"]) for name, about in declared.items()}
        self.folder, self.temporary = folder, tempfile.mkdtemp(dir=folder)
        self.outputs, self.path, self.summary, self.used, self.log = {}, [], "", [], ""

    def value(self, expression):
        """An expression, which uses only what is translated here."""
        code = re.sub(r"inputs\.([\w-]+)", lambda name: repr(self.inputs[name[1]]), expression)
        output = lambda name: repr(self.outputs.get(name[1], {}).get(name[2], ""))
        code = re.sub(r"steps\.([\w-]+)\.outputs\.([\w-]+)", output, code)
        code = code.replace("!cancelled()", "True").replace("&&", " and ").replace("||", " or ")
        return eval(code, {"__builtins__": {}})

    def filled(self, text):
        return re.sub(r"\$\{\{(.*?)\}\}", lambda found: str(self.value(found[1].strip())), str(text))

    def run(self):
        """The exit status: that of the first step that fails."""
        failed = 0
        for step in self.action["runs"]["steps"]:
            condition = step.get("if", "${{ True }}")
            if (failed and "cancelled()" not in condition) or self.filled(condition) != "True":
                continue
            if "uses" in step:
                self.used.append((step["uses"].split("@")[0], {k: self.filled(v) for k, v in step["with"].items()}))
                continue
            assert step["shell"] == "bash" and "${{" not in step["run"], "inputs come through the environment"
            files = {name: Path(self.temporary, name) for name in ("GITHUB_OUTPUT", "GITHUB_STEP_SUMMARY", "GITHUB_PATH")}
            for file in files.values():
                file.write_text("")
            script = Path(self.temporary, "step.sh")
            script.write_text(step["run"], encoding="utf-8")
            environment = {**os.environ, **{name: str(file) for name, file in files.items()},
                           "RUNNER_TEMP": self.temporary, "PATH": ":".join([*self.path, os.environ["PATH"]]),
                           **{name: self.filled(value) for name, value in step.get("env", {}).items()}}
            done = subprocess.run(["bash", "--noprofile", "--norc", "-eo", "pipefail", script], cwd=self.folder,
                                  env=environment, capture_output=True, text=True, timeout=300)
            self.log += done.stdout + done.stderr
            lines = dict(line.split("=", 1) for line in files["GITHUB_OUTPUT"].read_text().splitlines())
            self.outputs[step.get("id", "")] = lines
            self.summary += files["GITHUB_STEP_SUMMARY"].read_text(encoding="utf-8")
            self.path = files["GITHUB_PATH"].read_text().split() + self.path
            failed = failed or done.returncode
        return failed


def archives(folder):
    """What the release has, made of this program: an archive, a wheel, and the binary."""
    archive, wheel = Path(folder, "steward.tar.gz"), Path(folder, "wheels/steward_workbench-9.9.9-py3-none-any.whl")
    with tarfile.open(archive, "w:gz", compresslevel=1) as tar:
        tar.add(STEWARD, "steward-9.9.9/bin/steward")
        about = tarfile.TarInfo("steward-9.9.9/completions/steward")
        tar.addfile(about, io.BytesIO(b""))
    wheel.parent.mkdir()
    info = "steward_workbench-9.9.9.dist-info"
    with zipfile.ZipFile(wheel, "w") as zipped:
        script = zipfile.ZipInfo("steward_workbench-9.9.9.data/scripts/steward")
        script.external_attr = 0o100755 << 16
        zipped.writestr(script, f'#!/bin/sh\nexec "{STEWARD}" "$@"\n')
        zipped.writestr(f"{info}/METADATA", "Metadata-Version: 2.1\nName: steward-workbench\nVersion: 9.9.9\n")
        zipped.writestr(f"{info}/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        zipped.writestr(f"{info}/RECORD", "")
    return archive, wheel


def action(folder):
    checked = [SCRIPTS / "check-jsonschema", "--builtin-schema", "vendor.github-actions", ROOT / "action.yml"]
    subprocess.run(checked, check=True, capture_output=True)
    archive, wheel = archives(folder)
    digest = hashlib.sha256(archive.read_bytes()).hexdigest()
    server = http.server.ThreadingHTTPServer(
        ("127.0.0.1", 0), lambda *arguments: Quiet(*arguments, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    address = f"http://127.0.0.1:{server.server_port}/steward.tar.gz"
    scenario, violated = "robot/battery_fault.toml", 'properties=["robot/low.scope"]'

    # From an address, with a check, a run that fails, and everything uploaded. Nothing in an argument is code.
    attack = "a`touch hacked`$(touch hacked)'\";touch hacked"
    runner = Runner(folder, **{"archive": address, "sha256": digest, "check": scenario, "upload-sarif": "true",
                               "artifact": "robot", "arguments":
                               f"{scenario}\n--no-snapshots\n\n--set\n{violated}\n--set\nexpect={{}}\n--out\n{attack}"})
    assert runner.run() == 1, runner.log
    assert runner.outputs["check"] == {"status": "0"} and runner.outputs["run"] == {"status": "1"}, runner.outputs
    assert [uses for uses, _ in runner.used] == ["github/codeql-action/upload-sarif", "actions/upload-artifact"]
    assert runner.used[0][1] == {"sarif_file": "steward-results", "category": ""}
    assert "# steward check" in runner.summary and "# steward run" in runner.summary
    assert "in the artifact `robot`" in runner.summary
    assert Path(folder, attack, "report.json").exists() and not Path(folder, "hacked").exists()
    for ending in ("sarif", "xml", "md"):
        assert Path(folder, f"steward-results/run.{ending}").exists()

    # A wrong file: nothing is run, and its status is kept.
    runner = Runner(folder, archive=str(STEWARD), check=f"{scenario}\nwrong.scope", arguments=scenario)
    assert runner.run() == 2 and "run" not in runner.outputs and runner.used == [], runner.log
    # A path with its checksum; another program than expected; an address without one.
    fine = {"arguments": f"{scenario}\n--no-snapshots"}
    assert Runner(folder, archive="steward.tar.gz", sha256=digest, **fine).run() == 0
    runner = Runner(folder, archive="steward.tar.gz", sha256="0" * 64, **fine)
    assert runner.run() != 0 and "another checksum" in runner.log and "run" not in runner.outputs
    assert Runner(folder, archive=f"{address}?token=1", sha256=digest, **fine).run() == 0
    runner = Runner(folder, archive="steward.deb", **fine)
    assert runner.run() == 2 and "a tar.gz or a wheel" in runner.log
    runner = Runner(folder, archive=address, **fine)
    assert runner.run() == 2 and "needs its sha256" in runner.log
    # A subcommand, and arguments after `--`.
    subprocess.run([STEWARD, "campaign", "many.toml", "--quiet", "--shard", "0/1", "--out", "shards"], cwd=folder,
                   check=True, capture_output=True)
    for command, arguments in (("campaign", "merge\nshards\n--out\nmerged"), ("run", f"--no-snapshots\n--\n{scenario}")):
        runner = Runner(folder, archive="steward.tar.gz", command=command, arguments=arguments)
        assert runner.run() == 0 and f"# steward {command}" in runner.summary, runner.log
    # The wheel, from a file and by its version.
    os.environ.update(PIP_NO_INDEX="1", PIP_FIND_LINKS=str(wheel.parent))
    prove = {"command": "prove", "arguments": "nominal\n--property\nphi2\n--quiet"}
    assert Runner(folder, archive=str(wheel), **prove).run() == 0
    runner = Runner(folder, version="9.9.9", **fine)
    assert runner.run() == 0, runner.log
    assert os.listdir(runner.path[0]) == ["steward"], "the job keeps its own Python"
    # The program on the path; a command that is none of these; nothing to do.
    os.environ["PATH"] = f"{Path(runner.path[0])}:{os.environ['PATH']}"
    assert Runner(folder, command="", check=scenario).run() == 0
    runner = Runner(folder, command="tree", arguments="check", check=scenario)
    assert runner.run() == 2 and "the command is" in runner.log and runner.outputs["run"] == {"status": "2"}
    runner = Runner(folder, command="")
    assert runner.run() == 2 and "nothing to check" in runner.log
    server.shutdown()


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


def main():
    with tempfile.TemporaryDirectory() as folder:
        commands(folder)
        foreign_readers(folder)
        action(folder)
    print("results for CI systems: SARIF, JUnit and Markdown of seven commands, and the action's steps")


if __name__ == "__main__":
    main()
