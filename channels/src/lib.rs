//! Channel systems of program graphs: messages, processes, schedulers, monitored transitions.
