"""The same robot behind a bridge, the server of Foxglove's SDK (pip install foxglove-sdk): `bridge.py STEPS PORT`."""
import struct, sys, time

import foxglove
from lines import answer

steps, port = map(int, sys.argv[1:3])
context = foxglove.Context()
server = foxglove.start_server(host="127.0.0.1", port=port, name="a robot", context=context, supported_encodings=["cdr"])


def topic(name, kind, field):
    schema = foxglove.Schema(name=f"std_msgs/msg/{kind}", encoding="ros2msg", data=f"{field} data\n".encode())
    return foxglove.Channel(name, message_encoding="cdr", context=context, schema=schema)


level, stop, name = topic("/level", "Int32", "int32"), topic("/stop", "Bool", "bool"), topic("/map_name", "String", "string")


def go():
    # What is latched comes when somebody subscribes, from a bridge of ROS 2.
    name.log(b"\0\1\0\0\x06\0\0\0house\0")
    for step in range(steps):
        stop.log(b"\0\1\0\0" + bytes([step == 40]))
        level.log(b"\0\1\0\0" + struct.pack("<i", 60 - step))
        time.sleep(0.01)
    return {"done": steps}


answer(go)
