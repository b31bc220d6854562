//! The workspace and its dependencies, as `cargo metadata` describes them. (The crate `cargo_metadata` needs a feature
//! of serde_json that the program does not use: everything that depends on it would be built twice.)

use std::path::PathBuf;
use std::process::Command;

use serde::Deserialize;

/// The packages and, if dependencies are included, how they are resolved.
#[derive(Deserialize)]
pub(crate) struct Metadata {
    pub(crate) packages: Vec<Package>,
    pub(crate) resolve: Option<Resolve>,
}

#[derive(Clone, Deserialize)]
pub(crate) struct Package {
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) license: Option<String>,
    /// The registry, unless the package is in this workspace.
    pub(crate) source: Option<String>,
    pub(crate) manifest_path: PathBuf,
    pub(crate) dependencies: Vec<Dependency>,
    pub(crate) targets: Vec<Target>,
}

impl Package {
    /// The names of the packages that it needs, without those that only its tests or its build script need.
    pub(crate) fn normal_dependencies(&self) -> impl Iterator<Item = &str> {
        self.dependencies.iter().filter(|dependency| dependency.kind.is_none()).map(|dependency| &*dependency.name)
    }
}

#[derive(Clone, Deserialize)]
pub(crate) struct Dependency {
    name: String,
    kind: Option<String>,
}

#[derive(Clone, Deserialize)]
pub(crate) struct Target {
    pub(crate) kind: Vec<String>,
    pub(crate) src_path: PathBuf,
    /// Whether its own tests are run.
    pub(crate) test: bool,
    /// Whether the examples in its documentation are run.
    pub(crate) doctest: bool,
}

#[derive(Deserialize)]
pub(crate) struct Resolve {
    pub(crate) root: Option<String>,
    pub(crate) nodes: Vec<Node>,
}

#[derive(Deserialize)]
pub(crate) struct Node {
    pub(crate) id: String,
    deps: Vec<ResolvedDependency>,
}

impl Node {
    /// The packages that it needs, without those that only its tests or its build script need.
    pub(crate) fn normal_dependencies(&self) -> impl Iterator<Item = &str> {
        let normal = |dependency: &&ResolvedDependency| dependency.dep_kinds.iter().any(|kind| kind.kind.is_none());
        self.deps.iter().filter(normal).map(|dependency| &*dependency.pkg)
    }
}

#[derive(Deserialize)]
struct ResolvedDependency {
    pkg: String,
    dep_kinds: Vec<DependencyKind>,
}

#[derive(Deserialize)]
struct DependencyKind {
    kind: Option<String>,
}

/// The output of `cargo metadata` with these arguments.
pub(crate) fn metadata(arguments: &[&str]) -> Metadata {
    let arguments = [&["metadata", "--format-version=1", "--offline"], arguments].concat();
    serde_json::from_slice(&cargo(&arguments)).expect("the description is JSON")
}

/// The output of cargo in the workspace's folder.
pub(crate) fn cargo(arguments: &[&str]) -> Vec<u8> {
    let command = Command::new(env!("CARGO")).args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output();
    let output = command.expect("cargo runs");
    assert!(output.status.success(), "cargo {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}
