//! Where the values of a leaf's ports are while its machine runs.

/// The data of a machine in which the value of an input port arrives.
pub(crate) fn input_datum(port: &str) -> String {
    format!("bt_in__{port}")
}

/// The data of a machine in which it leaves the value of an output port.
pub(crate) fn output_datum(port: &str) -> String {
    format!("bt_out__{port}")
}

/// The process to which a leaf's machine sends its answers.
pub(crate) const TREE: &str = "BT";
