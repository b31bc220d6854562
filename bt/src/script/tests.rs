//! Scripts and their values.

use std::sync::Arc;

use super::{Names, Script};
use crate::Value;
use crate::blackboard::{Blackboard, Scope, Scopes, Slot};

struct Namespace(Scopes);

impl Names for Namespace {
    fn constant(&self, name: &str) -> Option<i64> {
        (name == "RED").then_some(7)
    }

    fn slot(&mut self, name: &str) -> Slot {
        self.0.slot(Scopes::ROOT, name)
    }
}

/// The value of a script's last expression, or its error.
fn value(script: &str) -> String {
    let mut table = Namespace(Scopes::default());
    table.0.push(Scope::default());
    let script = match Script::parse(script, &mut table).map(|(script, _)| script) {
        Ok(script) => script,
        Err(error) => return format!("{:?}: {}", error.range, error.message),
    };
    let entries = table.0.names().len();
    let mut board = Blackboard::new(Arc::new(table.0), vec![Default::default(); entries], 0, &[]);
    match script.run(&mut board) {
        Ok(Value::Real(number)) => format!("{number:?}"),
        Ok(Value::Text(text)) => format!("'{text}'"),
        Ok(value) => value.to_string(),
        Err(error) => error.to_string(),
    }
}

/// One test per pair of a script and its value.
macro_rules! amounts_to {
    ($($name:ident: [$($script:literal => $value:literal),* $(,)?];)*) => {
        $(
            #[test]
            fn $name() {
                $(assert_eq!(value($script), $value, "{}", $script);)*
            }
        )*
    };
}

amounts_to! {
    literals: ["1" => "1", "0x1F" => "31", "1.5" => "1.5", "2e3" => "2000.0", "'a b'" => "'a b'", "true" => "1.0", "false" => "0.0", "RED" => "7.0"];
    multiplication_binds_tighter_than_addition: ["1 + 2 * 3" => "7.0", "(1 + 2) * 3" => "9.0", "10 / 4 - 1" => "1.5"];
    operators_of_one_strength_go_from_left_to_right: ["10 - 4 - 3" => "3.0", "16 / 4 / 2" => "2.0"];
    arithmetic_is_that_of_real_numbers: ["7 / 2" => "3.5", "1 / 0" => "inf"];
    prefixes_bind_tightest: ["-2 * 3" => "-6.0", "!0 + 1" => "2.0", "~5" => "-6.0", "--1" => "1.0"];
    comparisons_answer_one_or_zero: ["1 < 2" => "1.0", "1 >= 2" => "0.0", "2 == 2" => "1.0", "2 != 2" => "0.0"];
    comparisons_can_be_chained: ["1 < 2 < 3" => "1.0", "1 < 3 < 2" => "0.0", "3 > 2 > 1 == 1" => "1.0"];
    equality_of_real_numbers_is_not_exact: ["0.1 + 0.2 == 0.3" => "1.0", "1.0 == 1.0001" => "0.0"];
    texts_are_compared_as_texts: ["'a' < 'b'" => "1.0", "'a' == 'a'" => "1.0", "'10' < '9'" => "1.0"];
    a_text_is_compared_to_a_number_as_a_number: ["'10' > 9" => "1.0", "1 == 'true'" => "1.0", "'x' == 1" => "`x` is not a number"];
    logic: ["1 && 0" => "0.0", "1 || 0" => "1.0", "true && true" => "1.0", "2 && 1" => "`&&` cannot be applied to `2` and `1`"];
    or_binds_looser_than_and: ["1 || 1 && 0" => "1.0"];
    bits: ["6 & 3" => "2.0", "6 | 3" => "7.0", "6 ^ 3" => "5.0", "1.5 & 1" => "`&` cannot be applied to `1.500000` and `1`"];
    and_of_bits_binds_tighter_than_or: ["1 | 2 & 0" => "1.0"];
    texts_are_joined: ["'a' .. 'b'" => "'ab'", "'a' + 'b'" => "'ab'", "'n' .. 3" => "'n3'", "1.5 .. 'm'" => "'1.500000m'"];
    two_numbers_are_not_joined: ["1 .. 2" => "`..` cannot be applied to `1` and `2`"];
    a_text_is_not_calculated_with: ["'a' - 1" => "`-` cannot be applied to `a` and `1`", "-'a'" => "`-` cannot be applied to `a`"];
    choice: ["1 ? 2 : 3" => "2", "0 ? 2 : 3" => "3", "0 ? 1 : 0 ? 2 : 3" => "3"];
    an_assignment_makes_an_entry_and_is_its_value: ["x := 3" => "3", "x := 3; x" => "3", "x := y := 2; x + y" => "4.0"];
    an_assignment_takes_all_that_follows: ["x := 1 < 2 ? 3 : 4" => "3"];
    assignments_that_calculate: ["x := 6; x += 2; x -= 1; x *= 4; x /= 2" => "14", "x := 'a'; x += 'b'" => "'ab'", "x := 'a'; x -= 'b'" => "`-` cannot be applied to `a` and `b`"];
    an_entry_that_does_not_exist_is_not_assigned_to: ["x = 1" => "the blackboard has no entry `x`; use `:=` to create one"];
    an_entry_that_does_not_exist_is_not_read: ["x" => "the blackboard has no entry `x`"];
    an_entry_without_a_value_is_not_read: ["x := x + 1" => "the entry `x` has no value yet"];
    statements_are_separated_by_semicolons: ["1; 2;; 3;" => "3", "1 2" => "2"];
    names_may_have_an_at_sign: ["@x := 4; x" => "4"];
    mistakes_are_found_at_their_places: [
        "" => "0..0: the script is empty",
        "1 +" => "3..3: expected a number, a string or a name",
        "(1" => "2..2: expected `)`",
        "1 = 2" => "0..1: only blackboard entries can be assigned to",
        "'abc" => "0..4: this string has no closing quote",
        "1 $ 2" => "2..3: `$` is not allowed in a script",
        "3foo" => "0..4: `3foo` is not a number",
        "65." => "0..3: `65.` is not a number",
        "99999999999999999999" => "0..20: `99999999999999999999` is not a number, or too large",
        "1 ? 2" => "5..5: expected `:` and the other choice",
    ];
}

#[test]
fn deep_nesting_is_refused() {
    assert!(value(&format!("{}1{}", "(".repeat(50), ")".repeat(50))) == "1");
    assert!(value(&"(".repeat(100_000)).contains("nested too deeply"));
    assert!(value(&"-".repeat(100_000)).contains("nested too deeply"));
    assert!(value(&format!("1{}", " + 1".repeat(100_000))).contains("too long"));
}

#[test]
fn a_text_has_a_maximum_length() {
    let doubled = |times: usize| value(&format!("x := 'a'{}; 1", "; x += x".repeat(times)));
    assert_eq!(doubled(20), "1", "a string of a megabyte");
    assert_eq!(doubled(21), "a string may have at most 1048576 bytes");
}
