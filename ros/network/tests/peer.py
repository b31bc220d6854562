"""A program of robots/, as the checks run it: with a Python of its own that has the packages that the program names."""
import atexit, json, os, signal, subprocess, tempfile
from pathlib import Path

ROBOTS = Path(__file__).parent / "robots"


class Peer:
    """A running program. `network` are the words of a command line that start it in another network."""

    def __init__(self, python, file, *args, network=(), **env):
        self.errors, pipe = tempfile.TemporaryFile("w+"), subprocess.PIPE
        words = [*network, python, ROBOTS / file, *map(str, args)]
        env = {**{name: value for name, value in os.environ.items() if name != "PYTHONPATH"}, **env}
        self.process = subprocess.Popen(words, stdin=pipe, stdout=pipe, stderr=self.errors, text=True, env=env)
        # Most programs do not end by themselves if the check fails.
        atexit.register(self.kill)
        assert self.heard() == {"up": True}, self.said()

    def heard(self):
        """Its next answer. Fast DDS writes warnings to the same output."""
        for line in self.process.stdout:
            if line[0] in "{[":
                return json.loads(line)
        raise AssertionError(f"{self.process.args} has ended: {self.said()}")

    def begin(self, what):
        self.process.stdin.write(what + "\n")
        self.process.stdin.flush()

    def ask(self, what):
        self.begin(what)
        return self.heard()

    def said(self):
        """Its errors and warnings."""
        self.errors.seek(0)
        return self.errors.read()

    def end(self):
        """Its last answer, after its input has ended."""
        self.process.stdin.close()
        last = self.heard()
        self.process.wait(timeout=60)
        return last

    def kill(self):
        self.process.kill()
        self.process.wait()


def children(process):
    """The processes that a process has started, from any of its threads."""
    tasks = Path(f"/proc/{process.pid}/task").iterdir()
    return [child for task in tasks for child in (task / "children").read_text().split()]


def go_on(pids):
    """Resumes processes that were stopped. One that was replaced meanwhile is gone."""
    for pid in pids:
        try:
            os.kill(int(pid), signal.SIGCONT)
        except ProcessLookupError:
            pass
