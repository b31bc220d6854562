"""What a node on rmw_cyclonedds has, without one, on Cyclone DDS (pip install cyclonedds): publishers, subscriptions,
services and clients. There, a request begins with its client and a number, and its response with the same.
"""
import os, random, time

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct, types
from cyclonedds.idl.annotations import final
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

LATCHED = Policy.Durability.TransientLocal, Policy.History.KeepLast(1), Policy.Reliability.Reliable(10**9)
NEWEST = Policy.Durability.Volatile, Policy.History.KeepLast(2), Policy.Reliability.BestEffort
participant = DomainParticipant(int(os.environ.get("ROS_DOMAIN_ID", "0")))


def struct(typename, **fields):
    kind = final(make_idl_struct(typename.split("::")[-1], typename, fields))
    kind.__idl__.xcdrv2_supported = False
    return kind


Correlation = struct("Header", client=types.uint64, number=types.int64)
Time = struct("builtin_interfaces::msg::dds_::Time_", sec=types.int32, nanosec=types.uint32)


def made(make, name, kind, *policies):
    """A reader or a writer, which has the QoS of rmw's services if it gets no other policies."""
    policies = policies or (Policy.Durability.Volatile, Policy.History.KeepLast(10), Policy.Reliability.Reliable(10**9))
    qos = Qos(*policies, Policy.DataRepresentation(use_cdrv0_representation=True))
    return make(participant, Topic(participant, name, kind, qos=qos), qos=qos)


def take(reader):
    return [sample for sample in reader.take(N=100) if sample.sample_info.valid_data]


class Endpoint:
    def __init__(self, name, kind, request, response):
        self.Request = struct(f"{kind}_Request_", header=Correlation, **request)
        self.Response = struct(f"{kind}_Response_", header=Correlation, **response)
        self.requests = made(self.makes[0], f"rq{name}Request", self.Request)
        self.responses = made(self.makes[1], f"rr{name}Reply", self.Response)


class Service(Endpoint):
    makes, responses_each = (DataReader, DataWriter), 1

    def take(self):
        return take(self.requests)

    def respond(self, request, **fields):
        for _ in range(self.responses_each):
            self.responses.write(self.Response(header=request.header, **fields))


class Client(Endpoint):
    makes = DataWriter, DataReader

    def __init__(self, *of):
        super().__init__(*of)
        self.id, self.sent, self.responses_by_number = random.getrandbits(64), 0, {}

    def send(self, **fields):
        """The number of a request, which its response will have."""
        self.sent += 1
        self.requests.write(self.Request(header=Correlation(self.id, self.sent), **fields))
        return self.sent

    def response(self, number, patience_s=10):
        """The response to a request, or None."""
        until = time.monotonic() + patience_s
        while number not in self.responses_by_number and time.monotonic() < until:
            own = [response for response in take(self.responses) if response.header.client == self.id]
            self.responses_by_number.update({response.header.number: response for response in own})
            time.sleep(0.005)
        return self.responses_by_number.get(number)
