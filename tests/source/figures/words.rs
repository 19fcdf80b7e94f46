//! A cargo command in its words.

/// Of cargo, before `--`: those alone, and those with a value.
const SWITCHES: [&str; 12] = [
    "--summary-only",
    "--release",
    "--locked",
    "--offline",
    "--quiet",
    "--no-run",
    "--all-features",
    "--no-default-features",
    "--doc",
    "--list",
    "--all-targets",
    "--lib",
];
const WITH_VALUES: [&str; 10] = [
    "--bench",
    "--test",
    "--example",
    "--features",
    "--manifest-path",
    "--target",
    "--target-dir",
    "-e",
    "-f",
    "--file",
];

/// Of the test runner, behind `--`.
const RUNNER_SWITCHES: [&str; 4] = ["--ignored", "--include-ignored", "--nocapture", "--exact"];

/// A cargo command, taken apart.
#[derive(Default)]
pub struct Words<'c> {
    /// Options with the values that follow them.
    pub options: Vec<(&'c str, Option<&'c str>)>,
    pub plain: Vec<&'c str>,
    /// Behind `--`.
    pub passed: Vec<&'c str>,
}

impl Words<'_> {
    pub fn value(&self, option: &str) -> Option<&str> {
        let found = self.options.iter().find(|(name, _)| *name == option)?;
        found.1
    }

    pub fn has(&self, option: &str) -> bool {
        self.options.iter().any(|(name, _)| *name == option)
    }

    pub fn passes(&self, switch: &str) -> bool {
        self.passed.contains(&switch)
    }
}

/// The words behind a subcommand; the error names an option that is not known.
pub fn split<'c>(words: &[&'c str]) -> Result<Words<'c>, String> {
    let (mut found, mut words) = (Words::default(), words.iter().copied());
    while let Some(word) = words.next() {
        match word {
            "--" => found.passed = words.by_ref().collect(),
            _ if SWITCHES.contains(&word) => found.options.push((word, None)),
            _ if WITH_VALUES.contains(&word) => {
                let value = words.next().ok_or(format!("{word} has no value"))?;
                found.options.push((word, Some(value)));
            }
            _ if word.starts_with('-') => return Err(format!("{word} is not known here")),
            _ => found.plain.push(word),
        }
    }
    Ok(found)
}

/// What the names of tests are to contain.
pub fn runner_filters<'c>(words: &Words<'c>) -> Result<Vec<&'c str>, String> {
    let (switches, filters): (Vec<&str>, Vec<&str>) =
        words.passed.iter().partition(|word| word.starts_with('-'));
    let is_known =
        |word: &&&str| RUNNER_SWITCHES.contains(*word) || word.starts_with("--test-threads=");
    match switches.iter().find(|word| !is_known(word)) {
        Some(unknown) => Err(format!("the test runner does not know {unknown}")),
        None => Ok(words.plain.iter().copied().chain(filters).collect()),
    }
}
