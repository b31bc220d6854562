import os, sys, sysconfig
from pathlib import Path


def program():
    """The program: in the folder for scripts of this environment, of the user, or wherever `pip --target` put it."""
    folders = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", sysconfig.get_preferred_scheme("user")),
               Path(__file__).parent.parent / "bin"]
    for folder in folders:
        path = Path(folder) / "steward"
        if path.is_file():
            return path
    sys.exit(f"steward: the program is in none of {', '.join(map(str, folders))}: install steward-workbench again")


path = str(program())
os.execv(path, [path, *sys.argv[1:]])
