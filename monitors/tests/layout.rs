//! The layout of property files changes nothing, and is that of its result.

use monitors::syntax::parse_file;
use monitors::{SHIPPED, layout};
use proptest::prelude::*;

use crate::language::file;

/// The layout of a text; its layout must be itself.
#[track_caller]
fn laid_out(text: &str) -> String {
    let lay_out = |text: &str| layout("test.scope", text).unwrap_or_else(|error| panic!("{error:?}\n{text}"));
    let once = lay_out(text);
    assert_eq!(lay_out(&once), once, "{text}");
    once
}

#[test]
fn tokens_are_separated_as_usual_and_stay_as_they_are_written() {
    for (text, expected) in [
        ("const  a:=5s;", "const a := 5 s;"),
        ("const a:=3 m/s", "const a := 3 m/s"),
        ("const a := 15%", "const a := 15 %"),
        ("property p:=□(a,b,m [ 1 ]=⟨ ok ⟩→m . level≥-3)", "property p := □(a, b, m[1] = ⟨ok⟩ → m.level ≥ -3)"),
        ("property p := (a,b,level -3>(x*2)/ s)", "property p := (a, b, level - 3 > (x * 2) / s)"),
        (
            "timed property p := once [<=5 s]((*,*,any( m.x>count(m.y=1) )))",
            "timed property p := once[<= 5 s] ((*, *, any(m.x > count(m.y = 1))))",
        ),
        ("property p := at most n(a,b,true)in 10 s", "property p := at most n (a, b, true) in 10 s"),
        (
            "property p := (a,b,m.since>since)since(a,b,true)",
            "property p := (a, b, m.since > since) since (a, b, true)",
        ),
        ("property \"a b\" := ! not(a,b,m[2] as x)", "property \"a b\" := !not (a, b, m[2] as x)"),
        ("property p := always (true and true", "property p := always (true and true"),
    ] {
        assert_eq!(laid_out(text), format!("{expected}\n"));
    }
}

#[test]
fn comments_and_blank_lines_stay_at_their_items() {
    let text = "\n\n// one\n\n\n  // two  \nconst a := 1 // three\nconst b := 2   const c := 3\n\n\n// four\n";
    let expected = "// one\n\n// two\nconst a := 1 // three\nconst b := 2\nconst c := 3\n\n// four\n";
    assert_eq!(laid_out(text), expected);
    assert_eq!(laid_out(""), "");
}

#[test]
fn a_long_property_is_broken_before_its_operators() {
    let event = |name: &str| format!("({name}, Navigation, m[1] = <start_navigation> and m.place = <Treasury>)");
    let [a, b, c, d] = ["FirstOfAll", "SecondOfAll", "ThirdOfAll", "FourthOfAll"].map(event);
    let text = format!("property p := always ({a} and {b} implies not ({c} or {d}))");
    let expected =
        format!("property p := always (\n    {a}\n        and {b}\n    implies not ({c}\n                 or {d}))\n");
    assert_eq!(laid_out(&text), expected);
    let text = format!("property p := not {a} until {b}");
    assert_eq!(laid_out(&text), format!("property p :=\n    not {a}\n    until {b}\n"));
}

#[test]
fn comments_inside_a_property_stay_at_their_tokens() {
    let text = "property p := always ( // why\n (a,b,true) // first\n // above\n implies // this\n\
                (a,b,false) // second\n) // end";
    let expected = "\
property p := always ( // why
    (a, b, true) // first
    // above
    implies // this
    (a, b, false) // second
) // end
";
    assert_eq!(laid_out(text), expected);
}

#[test]
fn a_text_that_cannot_be_parsed_is_refused() {
    for text in ["property", "property p := (", "const a = 1", "<scxml/>"] {
        assert!(layout("test.scope", text).is_err(), "{text}");
    }
}

#[test]
fn line_ends_are_kept() {
    assert_eq!(laid_out("// a\r\nconst  a := 1\r\n"), "// a\r\nconst a := 1\r\n");
}

#[test]
fn the_shipped_properties_have_their_layout() {
    for (name, text) in SHIPPED {
        assert_eq!(laid_out(text), text, "{name}");
    }
}

/// What may stand between two tokens besides a blank.
const BETWEEN: [&str; 6] = ["  ", "\n", "\n\n\n", " // c\n", "\n  // c\n\n// d\n", "\t"];

/// A text in which some blanks outside strings are something else, as the numbers choose.
fn disturbed(text: &str, numbers: &[u8]) -> String {
    let mut numbers = numbers.iter().cycle().map(|number| usize::from(*number));
    let (mut is_string, mut is_escaped) = (false, false);
    let mut out = String::new();
    for c in text.chars() {
        let number = numbers.next().unwrap_or(0);
        if c == '"' && !is_escaped {
            is_string = !is_string;
        }
        is_escaped = is_string && c == '\\' && !is_escaped;
        match c {
            ' ' if !is_string && number % 3 == 0 => out.push_str(BETWEEN[number / 3 % BETWEEN.len()]),
            _ => out.push(c),
        }
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(crate::cases::demanded("LAYOUTS", 100) as u32))]

    #[test]
    fn random_properties_keep_their_meaning(file in file(), numbers in prop::collection::vec(any::<u8>(), 1..200)) {
        let text = file.to_string();
        prop_assume!(!parse_file(&text).problems.iter().any(diagnostics::Problem::is_error));
        laid_out(&text);
        laid_out(&disturbed(&text, &numbers));
    }
}
