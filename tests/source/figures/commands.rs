//! Commands as documents name them: whether they can be typed, and whether they make figures.

use super::repository::{Repository, Target, knows_flags};
use super::test_names::{Test, tests_of};
use super::words::{Words, runner_filters, split};
use std::path::Path;

/// Subcommands that make no figures, or none that a document shows.
const OTHER_SUBCOMMANDS: [&str; 7] = ["clippy", "deny", "doc", "fmt", "install", "package", "tree"];

/// Whether a command makes figures; the error says why it cannot be typed.
type Verdict = Result<bool, String>;

impl Repository {
    /// `None` if it is no command that is known here.
    pub fn verdict(&self, command: &str) -> Option<Verdict> {
        // Brackets are around what may be left out.
        let mut words = command
            .split([' ', '[', ']'])
            .filter(|word| !word.is_empty())
            .peekable();
        let mut variables = Vec::new();
        while let Some((name, _)) = words.peek().and_then(|word| word.split_once('=')) {
            let is_letter = |byte| byte == b'_' || u8::is_ascii_uppercase(&byte);
            // Of one letter or two is the left side of a formula.
            if name.len() < 3 || !name.bytes().all(is_letter) {
                return None;
            }
            variables.push(name);
            words.next();
        }
        let is_read = self.are_read(&variables);
        let Some(program) = words.next() else {
            return (!variables.is_empty()).then(|| is_read.map(|()| false));
        };
        let words: Vec<&str> = words.collect();
        if words.is_empty() {
            return None;
        }
        let verdict = match program {
            "cargo" => self.cargo(&words),
            "python" | "python3" => self.script(&words),
            "pytest" => self.existing(words[0]).map(|path| path.is_file()),
            _ => return None,
        };
        Some(is_read.and(verdict))
    }

    fn cargo(&self, words: &[&str]) -> Verdict {
        let words = match words {
            [toolchain, rest @ ..] if toolchain.starts_with('+') => rest,
            all => all,
        };
        match words {
            ["bench", rest @ ..] => self.bench(&split(rest)?),
            ["test", rest @ ..] => self.test(&split(rest)?),
            ["run", rest @ ..] => self.example(&split(rest)?),
            ["build", rest @ ..] => self.build(&split(rest)?),
            ["mutants", rest @ ..] => self.mutants(&split(rest)?),
            ["llvm-cov", rest @ ..] => self.coverage(&split(rest)?),
            ["fuzz", "run", target, ..] => {
                let target = format!("fuzz/fuzz_targets/{target}.rs");
                self.existing(&target).map(|_| true)
            }
            [other, ..] if OTHER_SUBCOMMANDS.contains(other) || *other == "fuzz" => Ok(false),
            _ => Err("no such subcommand is known here".into()),
        }
    }

    fn bench(&self, words: &Words) -> Verdict {
        let Some(name) = words.value("--bench") else {
            return Ok(false);
        };
        let bench = self.target("bench", name)?;
        self.has_features(bench, words)?;
        knows_flags(own_sources(bench), &words.passed)?;
        Ok(!words.has("--no-run"))
    }

    fn example(&self, words: &Words) -> Verdict {
        let Some(name) = words.value("--example") else {
            return Ok(false);
        };
        let example = self.target("example", name)?;
        self.has_features(example, words)?;
        knows_flags(&self.root.join("examples"), &words.passed)?;
        Ok(true)
    }

    fn test(&self, words: &Words) -> Verdict {
        if words.has("--doc") {
            return self.doc_test(words);
        }
        let Some(name) = words.value("--test") else {
            // All tests: no figure is told by that.
            return Ok(false);
        };
        let target = self.target("test", name)?;
        self.has_features(target, words)?;
        let filters = runner_filters(words)?;
        let tests = tests_of(&target.source);
        for filter in &filters {
            let is_named = |test: &&Test| {
                let is_whole = !words.passes("--exact") || test.path.len() == filter.len();
                is_whole && test.path.contains(filter)
            };
            let mut named = tests.iter().filter(is_named).peekable();
            if named.peek().is_none() {
                return Err(format!("no test of {name} is named {filter}"));
            }
            if !named.any(|test| is_run(test, words)) {
                let all = format!("all tests of {name} named {filter}");
                return Err(format!("{all} are left out: ignored or not"));
            }
        }
        Ok(!filters.is_empty())
    }

    fn doc_test(&self, words: &Words) -> Verdict {
        let filters = runner_filters(words)?;
        for filter in &filters {
            if !self.chapters.iter().any(|chapter| chapter.contains(filter)) {
                return Err(format!("no chapter of the guide is named {filter}"));
            }
        }
        Ok(!filters.is_empty())
    }

    /// A package beside this one shows how long it takes.
    fn build(&self, words: &Words) -> Verdict {
        match words.value("--manifest-path") {
            Some(manifest) => self.existing(manifest).map(|_| true),
            None => Ok(false),
        }
    }

    /// Of all tests, or of a target.
    fn coverage(&self, words: &Words) -> Verdict {
        if let Some(name) = words.value("--test") {
            self.target("test", name)?;
        }
        Ok(true)
    }

    /// A list says nothing about tests.
    fn mutants(&self, words: &Words) -> Verdict {
        for (_, value) in words.options.iter().filter(|(name, _)| *name == "-f") {
            let glob = value.unwrap_or_default().trim_matches('\'');
            self.existing(glob.split('*').next().unwrap_or(glob))?;
        }
        Ok(!words.has("--list"))
    }

    fn script(&self, words: &[&str]) -> Verdict {
        if words[0].starts_with('-') {
            return Ok(false);
        }
        let path = self.existing(words[0])?;
        knows_flags(&path, &words[1..])?;
        Ok(true)
    }
}

/// Whether the test runner does not leave the test out.
fn is_run(test: &Test, words: &Words) -> bool {
    words.passes("--include-ignored") || test.is_ignored == words.passes("--ignored")
}

/// The file or the folder that is a bench's own.
fn own_sources(bench: &Target) -> &Path {
    let is_folder = bench
        .source
        .file_name()
        .is_some_and(|name| name == "main.rs");
    let own = bench.source.parent().filter(|_| is_folder);
    own.unwrap_or(&bench.source)
}
