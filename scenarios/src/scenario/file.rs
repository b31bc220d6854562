//! The scenario file, read and checked.

use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

use diagnostics::document::{Document, Key, Referent, Table};
use diagnostics::{FileProblems, Source, Span, Spanned};
use recording::{SettingGroup, Snapshots};

use super::asking;
use super::base::Base;
use super::component_entry::{self, ComponentEntry, read_components};
use super::execution::Execution;
use super::expectations::Expectations;
use super::find::Found;
use super::leaves::{LeafEntry, read_leaves};
use super::model_entry::ModelEntry;
use super::premises::{PremisesEntry, Sites, report_missing_map};
use super::prove::ProveEntry;
use super::ready_made::ReadyMade;
use super::robot::read_sim;
use super::settings;
use super::snapshots::read_snapshots;
use super::stop::Stop;
use super::world::{MAP, read_world};
use crate::faults::Fault;
use crate::files::{Files, named, path};

/// A scenario file, read and checked as far as possible without the files that it names. Its fields are the keys of the
/// file; those of a table are a struct.
#[derive(Clone, Debug)]
pub struct ScenarioFile {
    /// The subject of the scenario, on one line.
    pub about: String,
    /// The default of the root seed.
    pub seed: u64,
    /// The folder in which the other files are looked up first, if it is not the scenario's own.
    pub folder: Option<Spanned<PathBuf>>,
    /// The map and the robot on it; without one, tree, skills and components run alone.
    pub premises: Option<PremisesEntry>,
    /// Where tree and machines come from.
    pub behavior: BehaviorEntry,
    /// Names for numbers in scripts of the tree: the enumerators that the robot's program registers.
    pub constants: Vec<(String, i64)>,
    /// Leaves whose machines are in other files, or start with other data.
    pub leaves: Vec<LeafEntry>,
    /// Components from files.
    pub components: Vec<ComponentEntry>,
    /// The property files; all their properties are monitored.
    pub properties: Vec<Spanned<PathBuf>>,
    /// Where the property files are set: in the file, in a base or on the command line.
    properties_span: Option<Span>,
    /// The scenario's own file, its base, the base of that, and so on.
    sources: Vec<String>,
    /// The settings of robot, world and execution, given or not.
    pub settings: Vec<SettingGroup>,
    /// The folders to which the paths of its bases are relative.
    pub(super) base_folders: Vec<PathBuf>,
    /// The ready-made monitors.
    pub monitors: Vec<ReadyMade>,
    /// How tree, skills and components are run.
    pub execution: Execution,
    /// The faults.
    pub faults: Vec<Arc<Fault>>,
    /// When the run ends.
    pub stop: Stop,
    /// When pictures are taken.
    pub snapshots: Snapshots,
    /// The expected results of the run.
    pub expect: Expectations,
    /// The assumptions and questions of a proof.
    pub prove: ProveEntry,
}

/// Where the tree and the machines of a scenario come from.
#[derive(Clone, Debug)]
pub enum BehaviorEntry {
    /// Files of its own.
    Files(BehaviorFiles),
    /// A RoAML model, which has its own tree, skills and components.
    Model(ModelEntry),
}

/// The files of a scenario's tree and of its leaves.
#[derive(Clone, Debug)]
pub struct BehaviorFiles {
    /// The file with the behavior tree.
    pub tree: Spanned<PathBuf>,
    /// The folder with the machines of the tree's leaves: `<Leaf>.scxml`.
    pub skills: Spanned<PathBuf>,
}

impl BehaviorEntry {
    /// The file to begin with: that of the tree, or of the model.
    #[must_use]
    pub fn main_file(&self) -> &Spanned<PathBuf> {
        match self {
            Self::Files(files) => &files.tree,
            Self::Model(model) => &model.path,
        }
    }

    /// The model, if it is one.
    #[must_use]
    pub fn model(&self) -> Option<&ModelEntry> {
        match self {
            Self::Files(_) => None,
            Self::Model(model) => Some(model),
        }
    }

    /// The files, if it is no model.
    #[must_use]
    pub fn files(&self) -> Option<&BehaviorFiles> {
        match self {
            Self::Files(files) => Some(files),
            Self::Model(_) => None,
        }
    }
}

impl ScenarioFile {
    /// All keys of a scenario file except the parameters of its faults, which depend on their
    /// [kinds](crate::faults::KINDS).
    #[must_use]
    pub fn keys() -> &'static [Key] {
        static KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| Key::all(read_file));
        &KEYS
    }

    /// Reads a scenario. `name` is the file's name in diagnostics; `overrides` are assignments as for `--set`. Missing
    /// keys are inherited from the scenario that it names as its `base`, which is looked up in `files`.
    ///
    /// # Errors
    /// Everything that is wrong with the text, its base or the overrides.
    pub fn parse<'a>(
        name: &str,
        text: &str,
        files: &Files,
        overrides: impl IntoIterator<Item = &'a str>,
    ) -> Result<Self, FileProblems> {
        let (document, bases) = document(name, text, files, overrides)?;
        let mut file = document.read(read_file)?;
        file.settings = settings::in_effect(&document);
        // An assignment is no file beside which there are skills: those of the scenario stay.
        if let BehaviorEntry::Files(BehaviorFiles { tree, skills }) = &mut file.behavior
            && tree.span.is_assignment()
            && skills.span.is_assignment()
            && skills.span.source().text() == tree.span.source().text()
            && !files.are_shipped()
        {
            skills.value = PathBuf::from("skills");
        }
        let of_bases = bases.iter().map(|base| base.name().to_owned());
        file.sources = std::iter::once(name.to_owned()).chain(of_bases).collect();
        file.base_folders = bases.iter().map(|base| base.folder().to_owned()).collect();
        Ok(file)
    }

    /// The values of those of these top-level keys that the scenario has, including what it inherits and `overrides` as
    /// for `--set`.
    ///
    /// # Errors
    /// Syntax errors in the text, its bases or the overrides.
    pub fn values<'k>(
        found: &Found,
        overrides: &[String],
        keys: impl IntoIterator<Item = &'k str>,
    ) -> Result<toml::Table, FileProblems> {
        let (document, _) = document(&found.path, &found.text, &found.files, overrides.iter().map(String::as_str))?;
        Ok(keys.into_iter().filter_map(|key| Some((key.to_owned(), document.value(key)?))).collect())
    }
}

/// The tables whose entries have one of several forms: one that takes another form than the base's inherits nothing.
const FORMS: [(&str, &[&str]); 2] = [("components", &component_entry::FORMS), ("leaves", &asking::FORMS)];

/// A scenario's text with everything that it inherits and with `overrides`, and the files from which it inherits.
fn document<'a>(
    name: &str,
    text: &str,
    files: &Files,
    overrides: impl IntoIterator<Item = &'a str>,
) -> Result<(Document, Vec<Source>), FileProblems> {
    let overrides: Vec<&str> = overrides.into_iter().collect();
    let mut document = Document::parse_toml(name, text)?;
    // Inherited keys can be overridden only after the base is read; the base itself only before.
    let sets_base = |set: &&str| set.split_once('=').is_some_and(|(key, _)| key.trim() == "base");
    document.override_with(overrides.iter().copied().filter(sets_base))?;
    let bases = Base::all(&document, files)?;
    let (sources, documents): (Vec<Source>, Vec<Document>) =
        bases.into_iter().map(|base| (base.source, base.document)).unzip();
    let inherited = documents.into_iter().rev().reduce(|base, mut document| {
        document.inherit(base, &FORMS);
        document
    });
    if let Some(inherited) = inherited {
        document.inherit(inherited, &FORMS);
    }
    document.override_with(overrides)?;
    Ok((document, sources))
}

impl ScenarioFile {
    /// Whether an expectation applies to this property. A file's settings for its own properties do not apply if a
    /// scenario based on it names other property files, since the properties may be gone.
    pub fn means(&self, property: &Spanned<String>) -> bool {
        // How far away a value is set: on the command line, in the scenario itself, in its base, in the base of that.
        let distance =
            |span: &Span| self.sources.iter().position(|file| file == span.source().name()).map_or(0, |at| at + 1);
        self.properties_span.as_ref().is_none_or(|span| distance(&property.span) <= distance(span))
    }

    /// The files from which a scenario inherits: its base, the base of that, and so on.
    ///
    /// # Errors
    /// The problems of one of them.
    pub(crate) fn bases(found: &Found) -> Result<Vec<PathBuf>, FileProblems> {
        let bases = Base::all(&Document::parse_toml(&found.path, &found.text)?, &found.files)?;
        Ok(bases.into_iter().map(|base| base.path).collect())
    }
}

fn read_file(root: Table<'_>) -> Option<ScenarioFile> {
    let base = root.text("base").about(
        "Another scenario, as a file or by its name. This one inherits everything that it does not set itself. \
         An array is inherited as a whole or not at all, and so is an entry of `components` or `leaves` that \
         takes another form (`program` instead of `machine`). Inherited paths are relative to the file that \
         writes them, or to this one if there is nothing.",
    );
    let _ = base.refers_to(Referent::Scenario).optional();
    let about = root.text("about").about("What the scenario shows, on one line.").default(String::new());
    let seed = root.get::<u64>("seed");
    let seed = seed.about("The root seed unless `--seed` gives one. All random numbers of a run are derived from it.");
    let seed = seed.default(1);
    let folder = root.text("folder").about(
        "The folder in which the scenario's other files are looked up first, instead of its own. It does not apply to \
         the files of a base in another folder.",
    );
    let folder = folder.refers_to(Referent::File(&[])).map(PathBuf::from).spanned().optional();
    let about_map = "The map: a YAML file in the format of ROS's `map_server`. Without a map, there is no robot: tree, \
                     skills and components run on their own.";
    let map = path(root, MAP, about_map).refers_to(Referent::File(&["yaml", "yml"])).optional();
    let places = path(root, "places", "The places on the map: a TOML file, or a locations file of YARP (`.ini`).");
    let places = places.refers_to(Referent::Places).needs(MAP).optional();
    let behavior = read_behavior(root);
    let properties = root.get::<Vec<Spanned<String>>>("properties").words("an array of strings");
    let properties = properties.about("The property files. Each of their properties is monitored.");
    let properties = properties.refers_to(Referent::File(&["scope"]));
    let (properties, span) =
        properties.spanned().optional().map_or_else(Default::default, |list| (list.value, Some(list.span)));
    let properties = properties.into_iter().map(|Spanned { value, span }| Spanned { value: named(value, &span), span });
    let constants = read_constants(root);
    let leaves = read_leaves(root);
    let sites = Sites::read(root);
    let mut sim = read_sim(root);
    let components = read_components(root);
    let execution = Execution::read(root);
    sim.dt = execution.step();
    let world = read_world(root);
    sim.obstacles = world.iter().map(|body| body.value.clone()).collect();
    let premises = map.zip(sites).map(|(map, sites)| PremisesEntry { map, places, sites, sim, world });
    let monitors = ReadyMade::read_all(root);
    let faults = Fault::read_all(root);
    if let (Some(schedule), false) = (&execution.schedule, faults.is_empty()) {
        let problem = schedule.span.problem("a run that follows a schedule has no faults, but this scenario has some");
        let help = "remove them: `faults = []`; a schedule itself determines which messages are lost";
        root.report(problem.with_label("this schedule").with_help(help));
    }
    // An empty file has nothing that needs a map; and its reader determines which keys need one.
    if !root.has(MAP) && root.keys().next().is_some() {
        report_missing_map(root, ScenarioFile::keys(), &faults);
    }
    let stop = Stop::read(root);
    let snapshots = read_snapshots(root);
    let expect = Expectations::read(root);
    let prove = ProveEntry::read(root);
    Some(ScenarioFile {
        about,
        seed,
        folder,
        premises,
        behavior: behavior?,
        constants,
        leaves,
        components,
        properties: properties.collect(),
        properties_span: span,
        sources: Vec::new(),
        settings: Vec::new(),
        base_folders: Vec::new(),
        monitors,
        execution,
        faults,
        stop,
        snapshots,
        expect,
        prove: prove?,
    })
}

fn read_constants(root: Table<'_>) -> Vec<(String, i64)> {
    let about = "Names for numbers in the tree's scripts and switches, like the enumerators that a robot's program registers with \
                 BehaviorTree.CPP: `RED = 1`.";
    let Some(table) = root.table("constants").about(about).optional() else { return Vec::new() };
    let number = |(name, _): (&str, &Span)| {
        let number = table.get::<i64>(name).about("The number that the name stands for.").optional()?;
        Some((name.to_owned(), number))
    };
    table.names("NAME").filter_map(number).collect()
}

fn read_behavior(root: Table<'_>) -> Option<BehaviorEntry> {
    let model = ModelEntry::read(root);
    let files = root.form(model.is_none()).and_then(|root| {
        let tree = path(
            root,
            "tree",
            "The behavior tree: an XML file of BehaviorTree.CPP. Required unless there is a `base` or a `model`.",
        );
        let skills = path(
            root,
            "skills",
            "The folder of the SCXML machines that carry out the tree's leaves: those that `leaves` does not describe. By \
             default, `skills` beside the file that names the tree.",
        );
        let tree = tree.refers_to(Referent::File(&["xml"])).required();
        let skills = skills.refers_to(Referent::File(&[])).optional();
        let tree = tree?;
        let beside = || Spanned { value: named("skills", &tree.span), span: tree.span.clone() };
        Some(BehaviorFiles { skills: skills.unwrap_or_else(beside), tree })
    });
    model.map(BehaviorEntry::Model).or(files.map(BehaviorEntry::Files))
}
