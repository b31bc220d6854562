"""A network of their own for checks with nodes, isolated from other nodes on this machine."""
import os, subprocess, sys, time

LOOPBACK = "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo"


def paths():
    """The programs in the script's arguments. The script restarts in its own network, unless it is there already."""
    programs = [os.path.abspath(path) for path in sys.argv[1:]]
    if "IN_A_NETWORK" not in os.environ:
        words = [sys.executable, os.path.abspath(sys.argv[0]), *programs]
        script = [f'{LOOPBACK} && exec "$@"', "sh", *words]
        os.execvpe("unshare", ["unshare", "-rn", "sh", "-c", *script], {**os.environ, "IN_A_NETWORK": "1"})
    return programs


class Network:
    """Another network, which ends with the process that holds it."""

    def __init__(self):
        self.holder = subprocess.Popen(["unshare", "-n", "cat"], stdin=subprocess.PIPE)
        self.name = f"/proc/{self.holder.pid}/ns/net"
        while os.readlink(self.name) == os.readlink("/proc/self/ns/net"):
            time.sleep(0.01)
        self.inside = ["nsenter", f"--net={self.name}"]

    def run(self, script):
        subprocess.run([*self.inside, "sh", "-ec", script], check=True)
