//! Runnable items of this repository: targets, tests, chapters of the guide, scripts, and their variables and flags.

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Subcommands of cargo without a target in this repository.
const OTHER_SUBCOMMANDS: [&str; 11] = [
    "build", "clippy", "deny", "doc", "fmt", "install", "llvm-cov", "mutants", "package",
    "publish", "tree",
];

/// Prefixes of variables that libraries and tools read.
const FOREIGN_VARIABLES: [&str; 6] = [
    "RAYON_NUM_THREADS",
    "RAY_ADDRESS",
    "PDOC_ALLOW_EXEC",
    "CARGO_PROFILE_",
    "RUSTFLAGS",
    "RUSTDOCFLAGS",
];

/// Suffixes of variables that select the cases of a sweep (`tests/support/sweep.rs`).
const SWEEP_VARIABLES: [&str; 2] = ["_FIRST", "_PAIRS"];

/// Flags of the test runner.
const RUNNER_FLAGS: [&str; 5] = [
    "--ignored",
    "--include-ignored",
    "--nocapture",
    "--exact",
    "--test-threads",
];

/// The package of the examples.
const EXAMPLES: &str = "hydroelastic-examples";

/// Reason why a command cannot be typed.
type Verdict = Result<(), String>;

pub struct Repository {
    root: PathBuf,
    packages: Vec<Value>,
    targets: Vec<Target>,
    default_features: BTreeSet<String>,
}

struct Target {
    kind: String,
    name: String,
    source: PathBuf,
    needed_features: Vec<String>,
}

impl Repository {
    pub fn new(root: &Path) -> Self {
        let arguments = [
            "metadata",
            "--no-deps",
            "--format-version=1",
            "--locked",
            "--offline",
        ];
        let output = Command::new(env!("CARGO"))
            .args(arguments)
            .current_dir(root)
            .output();
        let metadata: Value = serde_json::from_slice(&output.unwrap().stdout).unwrap();
        let packages = metadata["packages"].as_array().unwrap();
        let targets = packages
            .iter()
            .flat_map(|package| package["targets"].as_array().unwrap());
        let mut named = packages.iter();
        let library = named
            .find(|package| package["name"] == "hydroelastic")
            .unwrap();
        Self {
            root: root.to_owned(),
            targets: targets.map(target).collect(),
            default_features: with_implied(&library["features"], "default"),
            packages: packages.clone(),
        }
    }

    /// Yields all benches by name and source.
    pub fn benches(&self) -> impl Iterator<Item = (&str, &Path)> {
        let benches = self.targets.iter().filter(|target| target.kind == "bench");
        benches.map(|bench| (bench.name.as_str(), bench.source.as_path()))
    }

    /// Returns whether a text is a command that can be typed, or `None` if it is no command known here.
    pub fn verdict(&self, command: &str) -> Option<Verdict> {
        // Brackets enclose optional parts.
        let words = command
            .split([' ', '[', ']'])
            .filter(|word| !word.is_empty());
        let words: Vec<&str> = words.collect();
        let is_variable = |word: &&&str| {
            let name = word.split_once('=').map_or("", |(name, _)| name);
            name.len() > 2 && name.bytes().all(|b| b == b'_' || b.is_ascii_uppercase())
        };
        let variables = words.iter().take_while(is_variable).count();
        let (variables, words) = words.split_at(variables);
        let [program, words @ ..] = words else {
            return None;
        };
        let verdict = match *program {
            "cargo" if !words.is_empty() => self.cargo(words),
            "python" | "python3" if !words.is_empty() => self.script(words),
            "pytest" if !words.is_empty() => self.existing(words[0]).map(|_| ()),
            _ => return None,
        };
        let mut names = variables
            .iter()
            .filter_map(|variable| variable.split('=').next());
        let are_read = names.try_for_each(|name| self.is_read(name));
        Some(are_read.and(verdict))
    }

    fn cargo(&self, words: &[&str]) -> Verdict {
        let words = match words {
            [toolchain, rest @ ..] if toolchain.starts_with('+') => rest,
            all => all,
        };
        let split = words
            .iter()
            .position(|word| *word == "--")
            .unwrap_or(words.len());
        let (cargo_words, passed) = words.split_at(split);
        let cargo_words = cargo_words.iter().flat_map(|word| word.splitn(2, '='));
        let cargo_words: Vec<&str> = cargo_words.collect();
        self.features_exist(&cargo_words)?;
        match cargo_words[..] {
            ["test", ..] if cargo_words.contains(&"--doc") => {
                let mut filters = cargo_words
                    .iter()
                    .filter(|word| word.starts_with("guide::"));
                filters.try_for_each(|filter| self.chapter(filter))
            }
            ["bench" | "run" | "test", ..] => self.target(&cargo_words, passed),
            ["fuzz", "run", name, ..] if !name.chars().all(char::is_uppercase) => {
                let target = format!("fuzz/fuzz_targets/{name}.rs");
                self.existing(&target).map(|_| ())
            }
            ["fuzz", ..] => Ok(()),
            [subcommand, ..] if OTHER_SUBCOMMANDS.contains(&subcommand) => Ok(()),
            _ => Err("no such subcommand is known here".into()),
        }
    }

    /// Checks the target that a command names, if it names one, and what the command passes to it after `--`.
    fn target(&self, cargo_words: &[&str], passed: &[&str]) -> Verdict {
        let value = |option: &str| value_of(option, cargo_words);
        let kinds = ["bench", "example", "test"].iter();
        let mut named = kinds.filter_map(|kind| Some((*kind, value(&format!("--{kind}"))?)));
        let Some((kind, name)) = named.next() else {
            return Ok(());
        };
        let mut of_kind = self.targets.iter().filter(|target| target.kind == kind);
        let target = of_kind.find(|target| target.name == name);
        let target = target.ok_or_else(|| format!("no {kind} is named {name}"))?;
        self.has_features(target, cargo_words, value("--features").unwrap_or_default())?;
        match kind {
            "test" => {
                let after_name = cargo_words
                    .iter()
                    .skip_while(|word| **word != "--test")
                    .skip(2);
                are_test_arguments(target, after_name.copied(), passed)
            }
            "bench" => knows_flags(folder_of(target), passed),
            _ if value("-p") == Some(EXAMPLES) => knows_flags(&self.root.join("examples"), passed),
            _ => Err(format!("examples are run with -p {EXAMPLES}")),
        }
    }

    /// Checks that a package that a command selects has the features that the command names.
    fn features_exist(&self, cargo_words: &[&str]) -> Verdict {
        let package = value_of("-p", cargo_words);
        let selected = |of: &&Value| package.is_none_or(|name| of["name"] == name);
        let packages = || self.packages.iter().filter(selected);
        let exists = |name: &&str| packages().any(|of| of["features"].get(name).is_some());
        let lists = value_of("--features", cargo_words).into_iter();
        let mut names = lists.flat_map(|list| list.split(','));
        match names.find(|name| !exists(name)) {
            Some(name) => Err(format!("no package has the feature {name}")),
            None => Ok(()),
        }
    }

    fn chapter(&self, filter: &str) -> Verdict {
        let guide = fs::read_to_string(self.root.join("src/guide.rs")).unwrap();
        let name = filter.trim_start_matches("guide::");
        if guide.contains(&format!("pub mod {name}")) {
            return Ok(());
        }
        Err(format!("no chapter of the guide is named {name}"))
    }

    fn script(&self, words: &[&str]) -> Verdict {
        if words[0].starts_with('-') {
            return Ok(());
        }
        knows_flags(&self.existing(words[0])?, &words[1..])
    }

    fn existing(&self, path: &str) -> Result<PathBuf, String> {
        let file = self.root.join(path);
        if file.exists() {
            Ok(file)
        } else {
            Err(format!("{path} does not exist"))
        }
    }

    /// Checks that a program of the repository reads an environment variable.
    fn is_read(&self, name: &str) -> Verdict {
        let is_in_sources = |text: &str| {
            ["tests", "benches"]
                .iter()
                .any(|folder| is_in(&self.root.join(folder), text))
        };
        let sweep = SWEEP_VARIABLES
            .iter()
            .find_map(|end| name.strip_suffix(end));
        let is_read = FOREIGN_VARIABLES
            .iter()
            .any(|foreign| name.starts_with(foreign))
            || sweep
                .is_some_and(|sweep| is_in_sources(&format!("range_from_environment(\"{sweep}\"")))
            || is_in_sources(&format!("var(\"{name}\""));
        if is_read {
            Ok(())
        } else {
            Err(format!("no program reads {name}"))
        }
    }

    fn has_features(&self, target: &Target, words: &[&str], named: &str) -> Verdict {
        let has_default = !words.contains(&"--no-default-features");
        let is_on = |feature: &&String| {
            words.contains(&"--all-features")
                || has_default && self.default_features.contains(*feature)
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

/// Returns the word after an option.
fn value_of<'w>(option: &str, words: &[&'w str]) -> Option<&'w str> {
    let index = words.iter().position(|word| *word == option)?;
    words.get(index + 1).copied()
}

/// Checks the filters of a test command and the flags of the test runner.
fn are_test_arguments<'w>(
    target: &Target,
    filters: impl Iterator<Item = &'w str>,
    passed: &[&'w str],
) -> Verdict {
    let words = passed.iter().copied().filter(|word| *word != "--");
    for word in filters.chain(words) {
        let flag = word.split('=').next().unwrap_or(word);
        if !word.starts_with('-') {
            runs_a_test(target, word, passed)?;
        } else if !RUNNER_FLAGS.contains(&flag) {
            return Err(format!("the test runner does not know {flag}"));
        }
    }
    Ok(())
}

/// Checks that a test target runs a test for a filter and the flags of the test runner.
fn runs_a_test(target: &Target, filter: &str, flags: &[&str]) -> Verdict {
    let is_run = |is_ignored: bool| {
        flags.contains(&"--include-ignored") || flags.contains(&"--ignored") == is_ignored
    };
    let mut tests = tests(target).into_iter();
    if tests.any(|(path, is_ignored)| path.contains(filter) && is_run(is_ignored)) {
        return Ok(());
    }
    Err(format!("{} runs no test named {filter}", target.name))
}

/// Returns the path of each test of a target, as in the output of the test runner, and whether the test is ignored.
fn tests(target: &Target) -> Vec<(String, bool)> {
    let folder = target.source.parent().unwrap();
    let of_file = |file: &PathBuf| {
        let module = file.strip_prefix(folder).unwrap().with_extension("");
        let modules = module.iter().map(|part| part.to_str().unwrap());
        let modules = modules.filter(|part| *part != "mod" && *file != target.source);
        let modules: Vec<&str> = modules.collect();
        let source = fs::read_to_string(file).unwrap();
        let items = source.split("#[test]\n").skip(1);
        let functions = items.filter_map(|item| item.split_once("fn "));
        let test = |(attributes, function): (&str, &str)| {
            let name = function.split('(').next().unwrap_or_default();
            let path = [&modules[..], &[name]].concat().join("::");
            (path, attributes.contains("#[ignore"))
        };
        functions.map(test).collect::<Vec<_>>()
    };
    let files = sources(folder_of(target));
    files.iter().flat_map(of_file).collect()
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

/// Returns a feature and all features that it enables.
fn with_implied(features: &Value, feature: &str) -> BTreeSet<String> {
    let implied = features[feature].as_array().into_iter().flatten();
    let further = implied.flat_map(|name| with_implied(features, name.as_str().unwrap()));
    further.chain([feature.to_owned()]).collect()
}

/// Returns the folder of a bench, or its file if the bench has no separate folder.
fn folder_of(bench: &Target) -> &Path {
    let is_folder = bench.source.ends_with("main.rs");
    if is_folder {
        bench.source.parent().unwrap()
    } else {
        &bench.source
    }
}

/// Checks that a program (a file or a folder of Rust) defines the flags among the words.
fn knows_flags(program: &Path, words: &[&str]) -> Verdict {
    for word in words
        .iter()
        .skip_while(|word| **word == "--")
        .filter(|word| word.starts_with("--"))
    {
        let flag = word.split('=').next().unwrap_or(word);
        if !is_in(program, &format!("\"{flag}\"")) {
            return Err(format!("the program does not know {flag}"));
        }
    }
    Ok(())
}

/// Returns whether a file, or a Rust file in a folder, contains the text.
fn is_in(path: &Path, text: &str) -> bool {
    let has =
        |path: &PathBuf| fs::read_to_string(path).is_ok_and(|contents| contents.contains(text));
    sources(path).iter().any(has)
}

/// Returns a file, or all Rust files in a folder and its subfolders.
fn sources(path: &Path) -> Vec<PathBuf> {
    if !path.is_dir() {
        return vec![path.to_owned()];
    }
    let entries = fs::read_dir(path)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let is_kept = |path: &PathBuf| {
        path.is_dir() || path.extension().is_some_and(|extension| extension == "rs")
    };
    entries
        .filter(is_kept)
        .flat_map(|path| sources(&path))
        .collect()
}
