//! Random applications without a map: a tree of leaves that answer by a script, late or not at all.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use rand::seq::IndexedRandom;
use rand::{Rng, RngExt};

use crate::brute_force::{Kind, Limit, Property};

/// A random application with its campaign: what was drawn, beside the files.
pub(crate) struct Application {
    pub(crate) campaign: PathBuf,
    pub(crate) properties: Vec<Property>,
    pub(crate) expected: Expected,
    pub(crate) max_time_s: Vec<f64>,
}

/// What the scenario expects.
#[derive(Default)]
pub(crate) struct Expected {
    /// The verdict of each property that is named; `any` among them.
    pub(crate) verdicts: Vec<(String, &'static str)>,
    pub(crate) errors: Vec<String>,
    /// The properties for which the end of a run is the end.
    pub(crate) final_for: Vec<String>,
}

const VERDICTS: [&str; 4] = ["satisfied", "violated", "inconclusive", "any"];

impl Application {
    /// Draws an application and writes its files.
    pub(crate) fn draw(folder: &Path, rng: &mut impl Rng) -> Self {
        let leaves: Vec<String> = (0..rng.random_range(2..5)).map(|number| format!("Leaf{number}")).collect();
        fs::create_dir_all(folder.join("skills")).unwrap();
        for leaf in &leaves {
            fs::write(folder.join("skills").join(format!("{leaf}.scxml")), machine(leaf, rng)).unwrap();
        }
        fs::write(folder.join("tree.xml"), tree(&leaves, rng)).unwrap();
        let properties: Vec<Property> =
            (0..rng.random_range(1..12)).map(|number| Property::draw(&format!("p{number}"), &leaves, rng)).collect();
        let text: String = properties.iter().map(|property| property.text.clone() + "\n").collect();
        fs::write(folder.join("p.scope"), text).unwrap();
        let expected = Expected::draw(&leaves, &properties, rng);
        let tick_s = [1.0, 0.7, 0.5, 1.3].choose(rng).unwrap();
        let scenario = format!(
            "tree = \"tree.xml\"\nskills = \"skills\"\nproperties = [\"p.scope\"]\n[execution]\ntick_s = {tick_s}\ntree = \"{}\"\n{}",
            ["whole", "nodes"].choose(rng).unwrap(),
            expected.text()
        );
        fs::write(folder.join("scenario.toml"), scenario).unwrap();
        let steps: BTreeSet<u32> = (0..rng.random_range(1..6)).map(|_| rng.random_range(1..700)).collect();
        let max_time_s: Vec<f64> = steps.into_iter().map(|steps| f64::from(steps) / 50.0).collect();
        let campaign = folder.join("campaign.toml");
        let parameter = format!("[[parameters]]\nkey = \"execution.max_time_s\"\nvalues = {max_time_s:?}\n");
        fs::write(&campaign, format!("scenario = \"scenario.toml\"\nsampling = \"grid\"\n{parameter}")).unwrap();
        Self { campaign, properties, expected, max_time_s }
    }
}

impl Expected {
    fn draw(leaves: &[String], properties: &[Property], rng: &mut impl Rng) -> Self {
        let mut expected = Self::default();
        for Property { name, .. } in properties {
            if rng.random_bool(0.5) {
                expected.verdicts.push((name.clone(), VERDICTS.choose(rng).unwrap()));
            }
            if rng.random_bool(0.4) {
                expected.final_for.push(name.clone());
            }
        }
        expected.errors = leaves.iter().filter(|_| rng.random_bool(0.4)).cloned().collect();
        expected
    }

    fn text(&self) -> String {
        let mut text = format!("[stop]\nfinal_for = {:?}\n[expect]\nerrors = {:?}\n", self.final_for, self.errors);
        for (name, verdict) in &self.verdicts {
            writeln!(text, "{name} = \"{verdict}\"").unwrap();
        }
        text
    }
}

fn tree(leaves: &[String], rng: &mut impl Rng) -> String {
    let control = ["Sequence", "Fallback", "ReactiveSequence", "ReactiveFallback"].choose(rng).unwrap();
    let children: String = leaves.iter().map(|leaf| format!("<{leaf}/>")).collect();
    let models: String = leaves.iter().map(|leaf| format!("<Action ID=\"{leaf}\" editable=\"true\"/>")).collect();
    format!(
        "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\"><BehaviorTree ID=\"Main\"><{control}>{children}</{control}>\
         </BehaviorTree><TreeNodesModel>{models}</TreeNodesModel></root>"
    )
}

/// A machine that answers its ticks by a script, which begins anew after its end; halts are confirmed, or not.
fn machine(name: &str, rng: &mut impl Rng) -> String {
    let length = rng.random_range(1..5);
    let mut answers = String::new();
    for place in 0..length {
        let answer = match rng.random_range(0..10) {
            0..4 => "<transition cond=\"HERE\" target=\"success\"/>",
            4..6 => "<transition cond=\"HERE\" target=\"failure\"/>",
            6..8 => "<transition cond=\"HERE\" target=\"running\"/>",
            8 => "<transition cond=\"HERE\" target=\"late\"/>",
            // Nothing is answered in time.
            _ => "<transition cond=\"HERE\" target=\"idle\"/>",
        };
        answers += &answer.replace("HERE", &format!("at == {place}"));
    }
    let send = |event: &str| format!("<send type=\"channel\" target=\"BT\" event=\"{event}\"/>");
    let halt = if rng.random_bool(0.6) {
        format!("<transition event=\"BT.halt\" target=\"idle\">{}</transition>", send("halted"))
    } else {
        "<transition event=\"BT.halt\" target=\"idle\"/>".to_owned()
    };
    let state = |answer: &str| {
        format!("<state id=\"{answer}\"><onentry>{}</onentry><transition target=\"idle\"/></state>", send(answer))
    };
    format!(
        "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" name=\"{name}\" initial=\"idle\">
         <datamodel><data id=\"at\" expr=\"-1\"/></datamodel>
         <state id=\"idle\">{halt}<transition event=\"BT.tick\" target=\"asked\"/></state>
         <state id=\"asked\">
           <onentry><assign location=\"at\" expr=\"at + 1\"/><if cond=\"at == {length}\"><assign location=\"at\" expr=\"0\"/></if></onentry>
           {answers}
         </state>
         <state id=\"late\"><onentry><send event=\"now\" id=\"now\" delay=\"{}ms\"/></onentry>
           <onexit><cancel sendid=\"now\"/></onexit>{halt}<transition event=\"now\" target=\"success\"/></state>
         {}{}{}</scxml>",
        rng.random_range(1..2500),
        state("success"),
        state("failure"),
        state("running"),
    )
}

impl Property {
    fn draw(name: &str, leaves: &[String], rng: &mut impl Rng) -> Self {
        let leaf = leaves.choose(rng).unwrap();
        let word = |leaf: &str, rng: &mut dyn FnMut(usize) -> usize| {
            let words = ["success", "failure", "running", "halted"];
            (leaf.to_owned(), "BT".to_owned(), words[rng(words.len())].to_owned())
        };
        let mut pick = |most: usize| rng.random_range(0..most);
        let first = word(leaf, &mut pick);
        let asked = ("BT".to_owned(), leaf.clone(), ["tick", "halt"][pick(2)].to_owned());
        let limit = Limit {
            relation: ["<", "<=", "="][pick(3)],
            ms: [20, 500, 700, 1000, 1300, 2000, 2100, 4000, 9000][pick(9)],
        };
        let kind = match pick(10) {
            0 => Kind::Ban(first),
            1 => Kind::Never(first),
            2 => Kind::Eventually(first),
            3 => Kind::Answered(asked, first),
            4 => Kind::Within(first, limit),
            5 => Kind::Provided(asked, first, limit),
            6 => Kind::Guarded(asked, first, word(leaf, &mut pick), limit),
            _ => {
                let soon = word(leaf, &mut pick);
                Kind::Either(asked, first, soon, [1, 4, 100][pick(3)])
            }
        };
        let timed = if kind.is_timed() { "timed " } else { "" };
        Self { name: name.to_owned(), text: format!("{timed}property {name} := {}", kind.formula()), kind }
    }
}
