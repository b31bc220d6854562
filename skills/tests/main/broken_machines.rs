//! Ten broken machines with several mistakes each: all mistakes are reported at once, each with its location.

use skills::{Chart, SkillError};

use crate::diagnostics::in_short;
use crate::stage::file;

/// Everything that is reported about a machine, errors and warnings.
fn complaints(text: &str) -> String {
    match Chart::load("broken.scxml", text) {
        Ok(chart) => in_short(text, chart.warnings()),
        Err(SkillError::Load { problems, .. }) => in_short(text, &problems),
        Err(other) => panic!("{other}"),
    }
}

macro_rules! broken {
    ($($name:ident: $attributes:expr, $content:expr;)*) => {$(
        #[test]
        fn $name() {
            insta::assert_snapshot!(complaints(&file($attributes, $content)));
        }
    )*};
}

broken! {
    broken_01_states_that_nothing_enters: "initial='a'",
        "<state id='a'><transition event='x' target='b'/></state>
         <state id='b'><state id='b1'/><state id='b2'><transition event='y' target='c'/></state></state>
         <state id='c'/><parallel id='p'><state id='p1'/><state id='p2'/></parallel>";
    broken_02_transitions_that_nothing_enables: "",
        "<state id='a'>
           <transition event='door' target='b'/><transition event='door.open' target='a'/>
           <transition event='e' cond='1 &gt; 2' target='b'/>
           <transition event='done.state.b' target='b'/><transition event='done.state.bb' target='b'/>
           <transition target='b'/><transition target='a'/>
         </state><state id='b'/>";
    broken_03_elements_that_scxml_does_not_have: "",
        "<state id='a'><onenter/><transitoin target='b'/><invok/>
           <x:note xmlns:x='urn:x'>ignored</x:note><transition event='e' traget='b'/></state><stat id='b'/>";
    broken_04_a_data_model_that_we_do_not_have: "datamodel='lua' binding='lazy' initial='nowhere'",
        "<datamodel><data id='x'/><data id='x'/><data id='1x'/></datamodel><state id='a'/>";
    broken_05_machines_that_cannot_be_invoked: "",
        "<state id='a'>
           <invoke/><invoke type='voicexml' src='form.vxml'/><invoke src='gone.scxml'/>
           <invoke autoforward='yes'><content><scxml xmlns='http://www.w3.org/2005/07/scxml' version='1.0'><state id='b'><transition target='gone'/></state></scxml></content>
             <finalize><raise event='e'/></finalize></invoke>
           <invoke id='i' idlocation='x' src='s' srcexpr='s'/>
         </state>";
    broken_06_names_that_stand_for_nothing: "",
        "<datamodel><data id='level' expr='30'/></datamodel>
         <state id='a'><onentry><assign location='levle' expr='1'/><log expr='levl + 1'/><assign location='_event.data' expr='1'/></onentry>
           <transition event='e' cond=\"In('b') || lvl &gt; 3\" target='aa'/></state>";
    broken_07_expressions_that_are_none: "",
        "<datamodel><data id='x' expr='1 +'/></datamodel>
         <state id='a'><transition event='e' cond='x == = 2'/><transition event='f' cond='(x'/>
           <onentry><foreach array='[1, 2' item='i'/><if cond=''><log/></if></onentry></state>";
    broken_08_messages_that_cannot_be_sent: "",
        "<state id='a'><onentry>
           <send/><send event='e' delay='soon'/><send event='e' type='smtp'/><send event='a b'/>
           <send event='e' target='#_internal' delay='1s'/><send event='e' eventexpr=\"'e'\"/>
           <send type='channel' event='go'/><cancel/><send event='e'><content>x</content><param name='p' expr='1'/></send>
         </onentry></state>";
    broken_09_states_that_contradict_each_other: "initial='p1 q'",
        "<parallel id='p'><state id='p1'/><state id='p2'/></parallel>
         <state id='q' initial='p1'><initial><transition target='q1'/></initial><state id='q1'/></state>
         <state id='q'><transition event='e' target='p1 q1'/></state>
         <history id='h' type='wide'/>";
    broken_10_events_and_branches_that_make_no_sense: "",
        "<state id='a'><transition event='a..b *.c' target='a'/><transition event='' target=''/>
           <onentry><raise event='x*'/><if cond='true'><else/><log/><elseif cond='false'/></if><raise/></onentry></state>
         text between the states";
}
