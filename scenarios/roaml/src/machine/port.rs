//! Where a leaf's machine keeps the values of ports while it runs.

pub(crate) fn input_datum(port: &str) -> String {
    format!("bt_in__{port}")
}

pub(crate) fn output_datum(port: &str) -> String {
    format!("bt_out__{port}")
}

/// The process to which a leaf's machine sends its answers.
pub(crate) const TREE: &str = "BT";
