//! The files from which a scenario inherits, and where the files are that these name.

use std::path::{Path, PathBuf};

use diagnostics::document::Document;
use diagnostics::{FileProblems, Source, Spanned};

use super::find;
use crate::files::{Files, named, scenario_names, unmarked};

pub(super) struct Base {
    /// Its path: relative to the scenario's folder, or that of a shipped file.
    pub(super) path: PathBuf,
    /// The folder of its file, relative to the scenario's. The files that a shipped scenario names may be replaced by
    /// others beside the file that is based on it.
    beside: PathBuf,
    /// Its file, however it is named.
    identity: PathBuf,
    /// Its text, with the folder to which its paths are relative.
    pub(super) source: Source,
    pub(super) document: Document,
}

impl Base {
    /// The base of a document whose file is in the folder `beside`, after these bases.
    fn of(document: &Document, beside: &Path, before: &[Self], files: &Files) -> Result<Option<Self>, FileProblems> {
        let Some(Spanned { value, span }) = document.peek_text("base") else { return Ok(None) };
        let on_disk = if span.is_assignment() { named(value, &span) } else { beside.join(unmarked(Path::new(value))) };
        let file = files.on_disk(&on_disk).filter(|found| !found.is_dir());
        let shipped = if file.is_none() { find::shipped(find::name_of(value).unwrap_or(value)) } else { None };
        let path = shipped.map_or(on_disk, PathBuf::from);
        let identity = file.and_then(|file| file.canonicalize().ok()).unwrap_or_else(|| path.clone());
        if before.iter().any(|base| base.identity == identity) {
            let problem = span.problem(format!("{value} is its own base, directly or indirectly"));
            return Err(problem.with_label("this base").with_help("bases must not form a cycle").into());
        }
        let text = files.read_text(&path).map_err(|error| {
            let problem = span.problem(format!("cannot read the base {value}: {error}"));
            let help = "a base is a scenario: a file beside this one, or the name of a shipped scenario";
            let meant = diagnostics::did_you_mean(value, scenario_names());
            problem.with_label("this base").with_help(meant.unwrap_or_else(|| help.to_owned()))
        })?;
        let beside = if shipped.is_some() { beside } else { path.parent().unwrap_or(Path::new("")) }.to_owned();
        let source = Source::new(&path.display().to_string(), text);
        let document = Document::of_toml(&source)?;
        Ok(Some(Self { path, beside, identity, source, document }))
    }

    /// All bases of a scenario: its base, the base of that, and so on.
    pub(super) fn all(document: &Document, files: &Files) -> Result<Vec<Self>, FileProblems> {
        let mut bases: Vec<Self> = Vec::new();
        loop {
            let last = bases.last().map_or((document, Path::new("")), |base| (&base.document, &base.beside));
            match Self::of(last.0, last.1, &bases, files)? {
                Some(base) => bases.push(base),
                None => break,
            }
        }
        // A `folder` applies to the files beside the one that sets it. Those elsewhere have their own.
        let folders: Vec<PathBuf> = bases.iter().map(|base| base.folder(&bases)).collect();
        for (base, folder) in bases.iter_mut().zip(folders).filter(|(base, _)| !base.beside.as_os_str().is_empty()) {
            base.source = Source::in_folder(folder, base.source.name(), base.source.text());
            base.document = Document::of_toml(&base.source)?;
            base.document.remove("folder");
        }
        Ok(bases)
    }

    /// The folder in which the files that it names are looked up, relative to the scenario's.
    fn folder(&self, all: &[Self]) -> PathBuf {
        let beside = all.iter().filter(|base| base.beside == self.beside);
        let named = beside.filter_map(|base| base.document.peek_text("folder")).next();
        named.map_or_else(|| self.beside.clone(), |folder| self.beside.join(folder.value))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::scenario::{Runs, Scenario, ScenarioFile, find::find};

    const TREE: &str = r#"<root BTCPP_format="4" main_tree_to_execute="Tour">
      <BehaviorTree ID="Tour"><SequenceWithMemory><GoToDestination/><AnnounceArrival/></SequenceWithMemory></BehaviorTree>
      <TreeNodesModel><Action ID="GoToDestination"/><Action ID="AnnounceArrival"/></TreeNodesModel>
    </root>"#;

    const BUILDING: &str = r#"base = "nominal"
map = "maps/floor.yaml"
places = "maps/floor.places.toml"
properties = ["said.scope"]
expect = {}
"#;

    const HOSPITAL: &str = r#"base = "../building/floor.toml"
tree = "tree.xml"
skills = "skills"
properties = ["said.scope", "properties/phi1.scope"]
components.Speaker = { machine = "parts/Speaker.scxml", interface = "parts/speaker.toml" }
components.Clerk.program = ["sh", "clerk.sh"]
[[monitors]]
machine = "watch.scxml"
violated_in = "bad"
events = [{ event = "trip", when = "(GoToDestination, Navigation, true)" }]
[[faults]]
kind = "wrong_map"
map = "maps/other.yaml"
at_s = 0
"#;

    /// A building, an application for it and a scenario of the application, each in its own folder.
    fn application(scenario: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        for made in ["building/maps", "hospital/skills", "hospital/parts", "hospital/maps", "wards/north"] {
            fs::create_dir_all(folder.path().join(made)).unwrap();
        }
        for (from, to) in [
            ("maps/house.yaml", "building/maps/floor.yaml"),
            ("maps/house.pgm", "building/maps/house.pgm"),
            ("maps/house.places.toml", "building/maps/floor.places.toml"),
            ("maps/house.yaml", "hospital/maps/other.yaml"),
            ("maps/house.pgm", "hospital/maps/house.pgm"),
            ("skills/examples/AnnounceArrival.scxml", "hospital/skills/AnnounceArrival.scxml"),
            ("skills/examples/Speaker.scxml", "hospital/parts/Speaker.scxml"),
            ("skills/examples/speaker.toml", "hospital/parts/speaker.toml"),
        ] {
            fs::copy(root.join(from), folder.path().join(to)).unwrap();
        }
        let watch = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" name="watch" datamodel="ecmascript" version="1.0" initial="on">
          <state id="on"><transition event="trip" target="bad"/></state><state id="bad"/></scxml>"#;
        for (path, text) in [
            ("building/floor.toml", BUILDING),
            ("hospital/hospital.toml", HOSPITAL),
            ("hospital/tree.xml", TREE),
            ("hospital/clerk.sh", "cat\n"),
            ("hospital/watch.scxml", watch),
            ("hospital/said.scope", "property said := always not (Speaker, AnnounceArrival, m[1] = <failed>)"),
            ("wards/north/own.scope", "property own := always not (GoToDestination, BT, m[1] = <failure>)"),
            ("wards/north/ward.toml", scenario),
        ] {
            fs::write(folder.path().join(path), text).unwrap();
        }
        folder
    }

    fn load(folder: &tempfile::TempDir, set: &[&str]) -> Result<Scenario, crate::Error> {
        let found = find(folder.path().join("wards/north/ward.toml").to_str().unwrap()).unwrap();
        let set: Vec<String> = set.iter().map(|set| (*set).to_owned()).collect();
        Scenario::load(&found, &set)
    }

    #[test]
    fn a_path_belongs_to_the_file_that_writes_it() {
        let folder = application("base = \"../../hospital/hospital.toml\"\n");
        let scenario = load(&folder, &[]).unwrap();
        let properties: Vec<&str> = scenario.properties.iter().map(|(path, _)| path.as_str()).collect();
        assert_eq!(properties, ["../../hospital/said.scope", "../../hospital/properties/phi1.scope"]);
        assert_eq!(scenario.skills.len(), 2, "a skill of its own and a shipped one");
        let Runs::Program { program, .. } = &scenario.components["Clerk"].runs else { panic!("no program") };
        assert!(program.folder().unwrap().join("clerk.sh").is_file());
        assert!(scenario.components.contains_key("Speaker") && scenario.premises.unwrap().wrong_map.is_some());

        let own = "base = \"../../hospital/hospital.toml\"\nproperties = [\"own.scope\"]\n";
        let properties = load(&application(own), &[]).unwrap().properties;
        assert_eq!(properties[0].0, "own.scope");
    }

    #[test]
    fn an_entry_of_another_form_inherits_nothing_from_its_base() {
        let own = "base = \"../../hospital/hospital.toml\"\ncomponents.Speaker.builtin = \"speaker\"\n\
                   components.Clerk.answer_within_s = 2\nleaves.GoToDestination.data.timeout = 9\n";
        let scenario = load(&application(own), &[]).unwrap();
        assert!(matches!(scenario.components["Speaker"].runs, Runs::Device { .. }), "no interface of the base");
        assert!(matches!(scenario.components["Clerk"].runs, Runs::Program { .. }), "the form is the base's");
    }

    #[test]
    fn a_folder_applies_to_the_files_beside_the_one_that_sets_it() {
        let folder = application("base = \"../../hospital/hospital.toml\"\nproperties = [\"own.scope\"]\n");
        let elsewhere = folder.path().join("elsewhere");
        fs::create_dir(&elsewhere).unwrap();
        fs::rename(folder.path().join("wards/north/own.scope"), elsewhere.join("own.scope")).unwrap();
        assert!(load(&folder, &[]).is_err());
        // On the command line, it is relative to the current folder.
        assert!(load(&folder, &["folder=../../elsewhere"]).is_err());
        let set = format!("folder={:?}", elsewhere.display().to_string());
        let scenario = load(&folder, &[&set]).unwrap();
        assert_eq!(scenario.properties[0].0, "own.scope");

        let hospital = folder.path().join("hospital");
        fs::create_dir(hospital.join("files")).unwrap();
        for moved in ["tree.xml", "skills", "parts", "watch.scxml", "maps", "clerk.sh"] {
            fs::rename(hospital.join(moved), hospital.join("files").join(moved)).unwrap();
        }
        assert!(load(&folder, &[&set]).is_err());
        fs::write(hospital.join("hospital.toml"), format!("folder = \"files\"\n{HOSPITAL}")).unwrap();
        load(&folder, &[&set]).unwrap();
    }

    #[test]
    fn what_is_not_beside_the_base_is_looked_up_beside_the_scenario() {
        let folder = application("base = \"../../hospital/hospital.toml\"\n");
        fs::rename(folder.path().join("hospital/tree.xml"), folder.path().join("wards/north/tree.xml")).unwrap();
        load(&folder, &[]).unwrap();
        fs::remove_file(folder.path().join("wards/north/tree.xml")).unwrap();
        assert!(load(&folder, &[]).is_err());
    }

    #[test]
    fn bases_that_name_each_other_from_different_folders_form_a_cycle() {
        let folder = application("base = \"../../hospital/hospital.toml\"\n");
        fs::write(folder.path().join("building/floor.toml"), "base = \"../wards/north/ward.toml\"\n").unwrap();
        let error = load(&folder, &[]).unwrap_err().to_string();
        assert!(error.contains("1 problem"), "{error}");
    }

    #[test]
    fn a_misspelt_base_is_told_what_may_be_meant() {
        for (base, help) in [("erand", "did you mean `errand`?"), ("nowhere/at/all.toml", "a base is a scenario: ")] {
            let parsed = ScenarioFile::parse("a.toml", &format!("base = \"{base}\"\n"), &Files::shipped(), []);
            let said = miette::Diagnostic::help(&parsed.unwrap_err().problems()[0]).map(|help| help.to_string());
            assert!(said.as_ref().is_some_and(|said| said.starts_with(help)), "{said:?}");
        }
    }
}
