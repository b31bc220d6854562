//! Values as JSON.

use super::Datum;

impl Datum {
    /// The value as JSON. Values that JSON lacks become what `JSON.stringify` makes of them (`null` for a number that
    /// is not finite), except that `undefined` becomes `null`, and functions and XML become strings.
    ///
    /// ```
    /// use skills::Datum;
    ///
    /// let list = Datum::array([Datum::Undefined, "a\"\n".into(), 1e21.into(), f64::NAN.into()])?;
    /// assert_eq!(list.to_json(), r#"[null,"a\"\n",1e+21,null]"#);
    /// # Ok::<(), skills::TooLarge>(())
    /// ```
    #[must_use]
    pub fn to_json(&self) -> String {
        let mut json = String::new();
        self.write_json(&mut json);
        json
    }

    fn write_json(&self, json: &mut String) {
        match self {
            Self::Undefined | Self::Null => json.push_str("null"),
            Self::Number(number) if !number.is_finite() => json.push_str("null"),
            Self::Bool(_) | Self::Number(_) => json.push_str(&self.to_text()),
            Self::Text(text) | Self::Function(text) | Self::Xml(text) => write_string(text, json),
            Self::Array(array) => {
                for (index, item) in array.items().iter().enumerate() {
                    // The first item brings the opening bracket, so an empty array gets both at the end.
                    json.push(if index == 0 { '[' } else { ',' });
                    item.write_json(json);
                }
                json.push_str(if array.items().is_empty() { "[]" } else { "]" });
            }
            Self::Object(object) => {
                json.push('{');
                for (index, (name, value)) in object.members().enumerate() {
                    if index > 0 {
                        json.push(',');
                    }
                    write_string(name, json);
                    json.push(':');
                    value.write_json(json);
                }
                json.push('}');
            }
        }
    }
}

/// Appends a text in quotes (JSON, RFC 8259 section 7).
pub(crate) fn write_string(text: &str, json: &mut String) {
    json.push('"');
    for letter in text.chars() {
        match letter {
            '"' => json.push_str("\\\""),
            '\\' => json.push_str("\\\\"),
            '\n' => json.push_str("\\n"),
            '\r' => json.push_str("\\r"),
            '\t' => json.push_str("\\t"),
            control if control < ' ' => {
                *json += &format!("\\u{:04x}", u32::from(control));
            }
            other => json.push(other),
        }
    }
    json.push('"');
}
