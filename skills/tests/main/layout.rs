//! The layout of machine files changes nothing, and is that of its result.

use proptest::prelude::*;
use skills::{ORIGINAL, SHIPPED, layout};

use crate::disturbed::disturbed;
use crate::properties::machine_text;
use crate::stage::file;

/// The layout of a text; its layout must be itself.
#[track_caller]
pub(crate) fn laid_out(text: &str) -> String {
    let lay_out = |text: &str| layout("test.scxml", text, None).unwrap_or_else(|error| panic!("{error:?}\n{text}"));
    let once = lay_out(text);
    assert_eq!(lay_out(&once), once, "{text}");
    once
}

#[test]
fn scripts_values_and_foreign_elements_are_kept() {
    let text = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" xmlns:x="urn:x" version="1.0" initial='a'>
<datamodel><data id="list"> [1,
   2] </data><data id='xml'><v> <w  a='1'/> </v></data></datamodel>
<script><![CDATA[ var a  = 1;
  var b = a < 2; ]]></script>
<state id="a"><x:note> <x:b  c='1'/></x:note><onentry><send event="e"><content> text  here </content></send></onentry>
<invoke><content><scxml version="1.0"><state id='inner'/></scxml></content></invoke></state></scxml>"#;
    let expected = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" xmlns:x="urn:x" version="1.0" initial="a">
  <datamodel>
    <data id="list"> [1,
   2] </data>
    <data id="xml"><v> <w  a='1'/> </v></data>
  </datamodel>
  <script><![CDATA[ var a  = 1;
  var b = a < 2; ]]></script>
  <state id="a">
    <x:note> <x:b  c='1'/></x:note>
    <onentry>
      <send event="e">
        <content> text  here </content>
      </send>
    </onentry>
    <invoke>
      <content>
        <scxml version="1.0">
          <state id="inner"/>
        </scxml>
      </content>
    </invoke>
  </state>
</scxml>
"#;
    assert_eq!(laid_out(text), expected);
}

#[test]
fn a_machine_that_would_be_refused_is_laid_out() {
    let text = file("", "<state id='a'><transition target='nowhere'/><onentry><log expr='1 +'/></onentry></state>");
    assert!(skills::Chart::load("test.scxml", &text).is_err());
    assert_eq!(laid_out(&text).lines().count(), 8);
}

#[test]
fn a_text_that_is_no_machine_is_refused() {
    for text in ["", "<scxml>", "<root/>", "<scxml a=1/>", "property p := true", "<roaml/>"] {
        assert!(layout("test.scxml", text, None).is_err(), "{text}");
    }
}

#[test]
fn the_shipped_machines_have_their_layout() {
    for (name, text) in SHIPPED.iter().chain(&ORIGINAL) {
        assert_eq!(laid_out(text), *text, "{name}");
    }
}

/// What a machine may contain besides states.
const CONTENTS: &str = r#"<datamodel><data id="a" expr="1 &lt; 2"/><data id="b">  [1, 2]
</data><data id="c"><v> <w x="1"/></v></data></datamodel><script><![CDATA[var d = '<'; ]]></script>"#;

/// How many random files.
fn cases() -> u32 {
    std::env::var("LAYOUTS").ok().and_then(|number| number.parse().ok()).unwrap_or(100)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases()))]

    #[test]
    fn random_machines_keep_their_meaning(
        text in machine_text(),
        numbers in prop::collection::vec(any::<u8>(), 1..200),
    ) {
        let start = text.find('>').unwrap() + 1;
        laid_out(&disturbed(&format!("{}{CONTENTS}{}", &text[..start], &text[start..]), &numbers));
        laid_out(&disturbed(&text, &numbers));
    }
}
