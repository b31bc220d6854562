"""A speaker: takes its time to say a text, then answers `ok`. It says one text at a time."""
import json
import sys

seconds_per_letter = 0.05
listener = None  # who waits until the text has been said

for line in sys.stdin:
    message = json.loads(line)
    event, data, answer = message["event"], message["data"], {}
    if event == "start":
        seconds_per_letter = data.get("seconds_per_letter", seconds_per_letter)
        answer = {"state": "silent"}
    elif event == "say" and listener is not None:
        reason = f"speaking to {listener}"
        answer = {"send": [{"to": message["from"], "event": "error", "data": {"reason": reason}}]}
    elif event == "say":
        listener = message["from"]
        duration = max(0.1, seconds_per_letter * len(data["text"]))
        answer = {"timers": [{"after": duration, "event": "said"}], "state": "speaking"}
    elif event == "said":
        answer = {"send": [{"to": listener, "event": "ok"}], "state": "silent"}
        listener = None
    print(json.dumps(answer), flush=True)
