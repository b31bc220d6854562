"""How these programs talk with whoever has started them: in lines of JSON, each of which may answer a line of words."""
import json, sys


def say(what):
    print(json.dumps(what), flush=True)


def answer(*functions, read=str):
    """Says that the program is up. Each line of its input is then the name of a function and its arguments, which are
    `read` from words, and what it returns is said.
    """
    by_name = {function.__name__: function for function in functions}
    say({"up": True})
    for line in sys.stdin:
        what, *words = line.split()
        say(by_name[what](*map(read, words)))
