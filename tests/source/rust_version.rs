//! No locked dependency requires a later Rust version than the manifest. For the code itself, clippy's `incompatible_msrv` checks the
//! version, because clippy knows since when each function of the standard library exists.

use serde_json::{Value, json};
use std::process::Command;

/// Major, minor and patch, in the order of comparison.
type Version = [u32; 3];

fn version(text: &str) -> Version {
    let mut parts = text.split('.').map(|part| part.parse().unwrap());
    [0; 3].map(|missing: u32| parts.next().unwrap_or(missing))
}

/// Returns the triple of the compiler's platform, whose packages are available without a network.
fn platform() -> String {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let output = Command::new(rustc).arg("-vV").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.unwrap().to_owned()
}

/// Returns the packages of this build with its features and tests. Other packages may not be downloaded.
fn packages() -> Vec<Value> {
    let has_all = cfg!(all(
        feature = "parquet",
        feature = "parry",
        feature = "serde"
    ));
    let features: &[&str] = if has_all { &["--all-features"] } else { &[] };
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version=1", "--locked", "--offline"])
        .args(["--filter-platform", &platform()])
        .args(features)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let refused = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{refused}");
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

/// Returns names and versions of the packages that require a later Rust version than promised.
fn too_demanding(packages: &[Value], promised: Version) -> Vec<String> {
    let asks_for_more = |package: &&Value| {
        let asked = package["rust_version"].as_str();
        asked.is_some_and(|asked| version(asked) > promised)
    };
    let described = |package: &Value| {
        let [name, version, rust] = ["name", "version", "rust_version"].map(|key| &package[key]);
        format!("{name} {version} asks for Rust {rust}")
    };
    let demanding = packages.iter().filter(asks_for_more);
    demanding.map(described).collect()
}

#[test]
fn no_locked_dependency_asks_for_a_later_rust_than_the_manifest_promises() {
    let (packages, promised) = (packages(), version(env!("CARGO_PKG_RUST_VERSION")));
    // One of the packages is this crate.
    assert!(packages.len() > 100, "{}", packages.len());
    let demanding = too_demanding(&packages, promised);
    assert!(demanding.is_empty(), "{demanding:#?}");
}

#[test]
fn a_package_that_asks_for_more_is_named_and_one_that_asks_for_nothing_is_not() {
    let asking = |name: &str, rust: Option<&str>| json!({"name": name, "version": "1.0.0", "rust_version": rust});
    let packages = [
        asking("equal", Some("1.90")),
        asking("earlier", Some("1.9.5")),
        asking("later", Some("1.90.1")),
        asking("silent", None),
    ];
    let expected = r#""later" "1.0.0" asks for Rust "1.90.1""#;
    assert_eq!(too_demanding(&packages, version("1.90")), [expected]);
}
