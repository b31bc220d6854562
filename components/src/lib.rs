//! Battery reader, localization and navigation as processes with drivers.
