"""A network of their own for the checks beside nodes: what is on this machine does not hear them, nor they it."""
import os, sys

NETWORK = "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && exec \"$@\""


def paths():
    """The programs in the script's arguments. The script starts anew in its own network, unless it is there already."""
    programs = [os.path.abspath(path) for path in sys.argv[1:]]
    if "IN_A_NETWORK" not in os.environ:
        words = [sys.executable, os.path.abspath(sys.argv[0]), *programs]
        os.execvpe("unshare", ["unshare", "-rn", "sh", "-c", NETWORK, "sh", *words], {**os.environ, "IN_A_NETWORK": "1"})
    return programs
