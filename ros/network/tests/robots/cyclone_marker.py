"""The same as marker.py, on Cyclone DDS (packages as for cyclone_ros.py)."""
import threading, time

import cyclone_ros
from cyclone_ros import NEWEST, made, struct
from cyclonedds.idl import types
from cyclonedds.pub import DataWriter
from lines import answer

Int32 = struct("std_msgs::msg::dds_::Int32_", data=types.int32)
topics = {"/count": (), "/mark": (), "/beat": NEWEST}
writers = {topic: made(DataWriter, f"rt{topic}", Int32, *quality) for topic, quality in topics.items()}
sent, is_over = {topic: [] for topic in topics}, threading.Event()


def send(topic, value):
    writers[topic].write(Int32(data=value))
    sent[topic].append(value)


def count():
    while not is_over.wait(0.02):
        for topic in ("/count", "/beat"):
            send(topic, len(sent[topic]))


def marks(*values):
    for value in values:
        send("/mark", value)
    return {"at": time.time()}


def truth():
    return sent


def leaves():
    is_over.set()
    counting.join()
    writers.clear()
    del cyclone_ros.participant
    return sent


counting = threading.Thread(target=count, daemon=True)
counting.start()
answer(marks, truth, leaves, read=int)
