"""A program of robots/ as the checks see it: in a Python of its own, which has the packages that it names."""
import atexit, json, os, signal, subprocess, tempfile
from pathlib import Path

ROBOTS = Path(__file__).parent / "robots"


class Peer:
    """One that is up. `network` are the words of a command line that start it in another network."""

    def __init__(self, python, file, *args, network=(), **env):
        self.errors, pipe = tempfile.TemporaryFile("w+"), subprocess.PIPE
        words = [*network, python, ROBOTS / file, *map(str, args)]
        env = {**{name: value for name, value in os.environ.items() if name != "PYTHONPATH"}, **env}
        self.process = subprocess.Popen(words, stdin=pipe, stdout=pipe, stderr=self.errors, text=True, env=env)
        # Many do not end by themselves if the check fails.
        atexit.register(self.kill)
        assert self.heard() == {"up": True}, self.said()

    def heard(self):
        """What it answers next. Fast DDS complains on the same output."""
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
        """What it has complained of."""
        self.errors.seek(0)
        return self.errors.read()

    def end(self):
        """What it answers last, when nothing more is asked of it."""
        self.process.stdin.close()
        last = self.heard()
        self.process.wait(timeout=60)
        return last

    def kill(self):
        self.process.kill()
        self.process.wait()


def children(process):
    """The processes that a process, which may have several threads, has started."""
    tasks = Path(f"/proc/{process.pid}/task").iterdir()
    return [child for task in tasks for child in (task / "children").read_text().split()]


def go_on(pids):
    """Lets processes that were stopped go on; one that has been replaced meanwhile is gone."""
    for pid in pids:
        try:
            os.kill(int(pid), signal.SIGCONT)
        except ProcessLookupError:
            pass
