//! What there is to run in this repository: targets, chapters of the guide, scripts, and the variables and flags they know.

use super::words::Words;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Variables that not this repository but its libraries and tools read.
const FOREIGN_VARIABLES: [&str; 4] = [
    "RAYON_NUM_THREADS",
    "RAY_ADDRESS",
    "PDOC_ALLOW_EXEC",
    "CARGO_PROFILE_",
];

/// Ends of the variables that say which cases of a sweep are tried (`tests/support/sweep.rs`).
const SWEEP_VARIABLES: [&str; 2] = ["_FIRST", "_PAIRS"];

/// What can be typed in this repository.
pub struct Repository {
    pub root: PathBuf,
    targets: Vec<Target>,
    default_features: BTreeSet<String>,
    /// Chapters of the guide, as its tests name them.
    pub chapters: Vec<String>,
}

pub struct Target {
    kind: String,
    pub name: String,
    pub source: PathBuf,
    pub needed_features: Vec<String>,
}

impl Repository {
    pub fn new(root: &Path) -> Self {
        let output = Command::new(env!("CARGO"))
            .args([
                "metadata",
                "--no-deps",
                "--format-version=1",
                "--locked",
                "--offline",
            ])
            .current_dir(root)
            .output()
            .unwrap();
        let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
        let package = &metadata["packages"][0];
        let guide = fs::read_to_string(root.join("src/guide.rs")).unwrap();
        let modules = guide
            .lines()
            .filter_map(|line| line.strip_prefix("pub mod "));
        let chapter = |rest: &str| format!("guide::{}", rest.trim_end_matches(" {}"));
        Self {
            root: root.to_owned(),
            targets: package["targets"]
                .as_array()
                .unwrap()
                .iter()
                .map(target)
                .collect(),
            default_features: with_implied(&package["features"], "default"),
            chapters: modules.map(chapter).collect(),
        }
    }

    /// All benches, by name and source.
    pub fn benches(&self) -> impl Iterator<Item = (&str, &Path)> {
        let benches = self.targets.iter().filter(|target| target.kind == "bench");
        benches.map(|bench| (bench.name.as_str(), bench.source.as_path()))
    }

    /// Whether programs here read all these variables of the environment; the error names one that none reads.
    pub fn are_read(&self, names: &[&str]) -> Result<(), String> {
        let is_foreign = |name: &str| {
            FOREIGN_VARIABLES
                .iter()
                .any(|foreign| name.starts_with(foreign))
        };
        let is_in_sources = |text: &str| {
            ["tests", "benches"]
                .iter()
                .any(|folder| is_in(&self.root.join(folder), text))
        };
        let is_of_sweep = |name: &str| {
            let sweep = SWEEP_VARIABLES
                .iter()
                .find_map(|end| name.strip_suffix(end));
            sweep.is_some_and(|sweep| is_in_sources(&format!("range_from_environment(\"{sweep}\"")))
        };
        let is_read = |name: &str| {
            is_foreign(name) || is_of_sweep(name) || is_in_sources(&format!("var(\"{name}\""))
        };
        match names.iter().find(|name| !is_read(name)) {
            Some(unread) => Err(format!("no program reads {unread}")),
            None => Ok(()),
        }
    }

    pub fn existing(&self, path: &str) -> Result<PathBuf, String> {
        let found = self.root.join(path);
        if found.exists() {
            Ok(found)
        } else {
            Err(format!("{path} does not exist"))
        }
    }

    pub fn target(&self, kind: &str, name: &str) -> Result<&Target, String> {
        let mut of_kind = self.targets.iter().filter(|target| target.kind == kind);
        of_kind
            .find(|target| target.name == name)
            .ok_or_else(|| format!("no {kind} is named {name}"))
    }

    pub fn has_features(&self, target: &Target, words: &Words) -> Result<(), String> {
        let named = words.value("--features").unwrap_or_default();
        let is_on = |feature: &&String| {
            let is_default =
                !words.has("--no-default-features") && self.default_features.contains(*feature);
            words.has("--all-features")
                || is_default
                || named.split(',').any(|name| name == *feature)
        };
        match target
            .needed_features
            .iter()
            .find(|feature| !is_on(feature))
        {
            Some(feature) => Err(format!("{} needs the feature {feature}", target.name)),
            None => Ok(()),
        }
    }
}

fn target(target: &Value) -> Target {
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let features = target["required-features"].as_array();
    Target {
        kind: text(&target["kind"][0]),
        name: text(&target["name"]),
        source: PathBuf::from(text(&target["src_path"])),
        needed_features: features.map_or(Vec::new(), |all| all.iter().map(text).collect()),
    }
}

/// A feature and all that it switches on.
fn with_implied(features: &Value, feature: &str) -> BTreeSet<String> {
    let implied = features[feature].as_array().into_iter().flatten();
    let further = implied.flat_map(|name| with_implied(features, name.as_str().unwrap()));
    further.chain([feature.to_owned()]).collect()
}

/// Whether a program, a file or a folder of Rust, has the flags among the words; the error names one that it has not.
pub fn knows_flags(program: &Path, words: &[&str]) -> Result<(), String> {
    for word in words.iter().filter(|word| word.starts_with("--")) {
        let flag = word.split('=').next().unwrap_or(word);
        let literal = format!("\"{flag}\"");
        if !is_in(program, &literal) {
            return Err(format!("the program does not know {flag}"));
        }
    }
    Ok(())
}

/// Whether a file, or a file of Rust in a folder, has the text.
fn is_in(path: &Path, text: &str) -> bool {
    if path.is_dir() {
        let entries = fs::read_dir(path)
            .unwrap()
            .map(|entry| entry.unwrap().path());
        let is_source = |path: &PathBuf| {
            path.is_dir() || path.extension().is_some_and(|extension| extension == "rs")
        };
        return entries.filter(is_source).any(|path| is_in(&path, text));
    }
    fs::read_to_string(path).is_ok_and(|found| found.contains(text))
}
