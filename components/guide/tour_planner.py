"""Plans tours of a museum: knows the stops, what there is to say about them, and which are done.

A wish that names a stop puts it first; one that names the exit ends the tour there.
"""
import json
import sys

TEXTS = {
    "Paintings": "These are views of the harbour. The painter never saw it: he worked from letters.",
    "Sculptures": "The three figures were one block of marble. Look for the line that runs through all of them.",
    "Treasury": "This is the crown of a very small kingdom. It weighs less than an apple.",
    "Entrance": "This is the end of our tour. Thank you for coming, and goodbye!",
}
EXIT = "Entrance"


class Tour:
    """What is left of a tour."""

    def __init__(self, stops):
        self.stops = stops
        self.begin()

    def begin(self):
        self.todo = [*self.stops, EXIT]

    def fulfil(self, wish):
        if "exit" in wish:
            self.todo = [EXIT]
        wished = [stop for stop in self.todo if stop.lower() in wish]
        self.todo = wished + [stop for stop in self.todo if stop not in wished]

    def answer(self, request, data):
        """The answer to a request: its first symbol, and its fields."""
        if request == "begin_tour":
            self.begin()
        elif request == "tick_off":
            self.todo = [stop for stop in self.todo if stop != data["place"]]
        elif request == "next_stop":
            self.fulfil(data["wish"])
            if not self.todo:
                return "error", {"reason": "the tour is over"}
            return "ok", {"place": self.todo[0], "text": TEXTS[self.todo[0]]}
        return "ok", {}


def count(number, thing):
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"


tour, said = None, 0
for line in sys.stdin:
    message = json.loads(line)
    event, data, reaction = message["event"], message["data"], {}
    if event == "start":
        tour = Tour(data["stops"].split(", "))
    elif event == "spoken":
        said += 1
    else:
        head, fields = tour.answer(event, data)
        reaction["send"] = [{"to": message["from"], "event": head, "data": fields}]
    reaction["state"] = f"{count(len(tour.todo), 'stop')} left, {count(said, 'text')} said"
    print(json.dumps(reaction), flush=True)
