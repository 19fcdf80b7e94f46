//! Module dependencies: which modules a module may use, and which modules may use external libraries.
//!
//! The checker takes pairs of a path below `src` and a text, so that it can be tested on invalid sources too.

use crate::circles::in_circles;
use std::fs;
use std::path::Path;

/// Modules in order of dependency. A module uses only modules before it.
const MODULES: [&str; 19] = [
    "guide",
    "parallel",
    "lanes",
    "scalar",
    "spatial",
    "geometry",
    "friction",
    "bvh",
    "mesh",
    "broad_phase",
    "seeds",
    "contact_shape",
    "narrow_phase",
    "search",
    "contact",
    "dynamics",
    "gradient",
    "identification",
    "io",
];

/// External libraries, and the modules that may use them.
const DOORS: [(&str, &[&str]); 16] = [
    ("pulp", &["lanes"]),
    ("wide", &["friction", "lanes"]),
    ("rstar", &["broad_phase"]),
    ("num_dual", &["scalar"]),
    ("rayon", &["parallel"]),
    ("num_traits", &["scalar"]),
    ("base64", &["io"]),
    ("miniz_oxide", &["io"]),
    ("robust", &["mesh"]),
    ("csv", &["io"]),
    ("faer", &["dynamics"]),
    ("gltf_json", &["io"]),
    ("parry3d_f64", &["io"]),
    ("parquet", &["io"]),
    ("roxmltree", &["io"]),
    (
        "serde",
        &["spatial", "mesh", "dynamics", "gradient", "identification"],
    ),
];

/// Libraries whose types are in public interfaces. The crate's root re-exports these libraries.
const SHOWN: [&str; 2] = ["nalgebra", "num_dual"];

/// Conversions between `f64` and the scalar that bypass `lift` and `real_part`.
const BACK_DOORS: [&str; 2] = [".re()", "T::from("];

/// Meaningless names of modules.
const EMPTY_NAMES: [&str; 3] = ["utils", "common", "helpers"];

/// Returns the violations in the source files, one message each.
fn violations(files: &[(String, String)]) -> Vec<String> {
    let of_file = |(path, text): &(String, String)| {
        let code = code_of(text);
        let mut violations = file_violations(path);
        violations.extend(uphill_imports(path, &code));
        violations.extend(wrong_doors(path, &code));
        violations
            .into_iter()
            .map(|message| format!("{path} {message}"))
            .collect::<Vec<_>>()
    };
    files
        .iter()
        .flat_map(of_file)
        .chain(circles(files))
        .collect()
}

fn circles(files: &[(String, String)]) -> impl Iterator<Item = String> {
    let codes = files
        .iter()
        .map(|(path, text)| (path.clone(), code_of(text)));
    let circles = in_circles(&codes.collect::<Vec<_>>()).into_iter();
    circles.map(|(path, imports)| {
        let imports: Vec<_> = imports.into_iter().collect();
        format!(
            "{path} is in a circle of files: it imports {}",
            imports.join(", ")
        )
    })
}

fn file_violations(path: &str) -> Vec<String> {
    let mut violations = Vec::new();
    let module = module_of(path);
    if module != "lib" && !MODULES.contains(&module) {
        violations.push(format!(
            "belongs to {module}, which is not on the list of modules"
        ));
    }
    for name in path.trim_end_matches(".rs").split('/') {
        if EMPTY_NAMES.contains(&name) {
            violations.push(format!("is named {name}"));
        }
    }
    violations
}

fn uphill_imports(path: &str, code: &str) -> Vec<String> {
    let mut violations = Vec::new();
    if code.contains("super::super") {
        violations.push("climbs by super::super".to_owned());
    }
    let Some(rank_here) = rank(module_of(path)) else {
        return violations;
    };
    let mut targets = names_after("crate::", code);
    if is_module_root(path) {
        targets.extend(
            names_after("super::", code)
                .into_iter()
                .filter(|name| rank(name).is_some()),
        );
    }
    for target in targets {
        match rank(&target) {
            None => violations.push(format!(
                "uses crate::{target}, which is not on the list of modules"
            )),
            Some(target_rank) if target_rank > rank_here => {
                violations.push(format!("uses {target}, which comes after it"));
            }
            Some(_) => {}
        }
    }
    violations
}

fn wrong_doors(path: &str, code: &str) -> Vec<String> {
    let module = module_of(path);
    let is_shown = |library: &str| path == "lib.rs" && SHOWN.contains(&library);
    let libraries = DOORS
        .iter()
        .filter(|(library, rooms)| !rooms.contains(&module) && has_word(code, library))
        .filter(|(library, _)| !is_shown(library))
        .map(|(library, _)| format!("uses {library}"));
    let back_doors = BACK_DOORS
        .iter()
        .filter(|back_door| module != "scalar" && code.contains(**back_door))
        .map(|back_door| format!("has {back_door}: use lift or real_part"));
    libraries.chain(back_doors).collect()
}

/// Returns the top-level module of a file: `mesh` for `mesh/tet_mesh.rs`, `lib` for `lib.rs`.
fn module_of(path: &str) -> &str {
    path.split('/')
        .next()
        .unwrap_or(path)
        .trim_end_matches(".rs")
}

/// Returns whether `super` is the crate itself in this file.
fn is_module_root(path: &str) -> bool {
    let parts: Vec<&str> = path.split('/').collect();
    matches!(parts[..], [_] | [_, "mod.rs"])
}

fn rank(module: &str) -> Option<usize> {
    MODULES.iter().position(|name| *name == module)
}

/// Returns the lines above the module of unit tests. A test-only item elsewhere does not end them.
fn lines_before_tests(text: &str) -> impl Iterator<Item = &str> {
    let following = text.lines().skip(1).chain([""]);
    text.lines()
        .zip(following)
        .take_while(|(line, next)| {
            !(*line == "#[cfg(test)]" && next.starts_with("mod ") && !next.ends_with(';'))
        })
        .map(|(line, _)| line)
}

/// Returns the text without comments (documentation may link anywhere) and unit tests.
fn code_of(text: &str) -> String {
    lines_before_tests(text)
        .map(|line| line.split("//").next().unwrap_or(line))
        .fold(String::new(), |code, line| code + line + "\n")
}

/// Returns the first names of all paths that start with `prefix`, including those in a group such as `crate::{mesh::TetMesh, scalar}`.
fn names_after(prefix: &str, code: &str) -> Vec<String> {
    code.match_indices(prefix)
        .filter(|(start, _)| !code[..*start].ends_with(is_word_character))
        .flat_map(|(start, _)| path_heads(&code[start + prefix.len()..]))
        .collect()
}

fn path_heads(rest: &str) -> Vec<String> {
    let Some(group) = rest.strip_prefix('{') else {
        return vec![first_word(rest)];
    };
    let mut depth = 0;
    let mut heads = vec![first_word(group)];
    for (index, character) in group.char_indices() {
        match character {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => heads.push(first_word(&group[index + 1..])),
            _ => {}
        }
    }
    // A trailing comma makes an empty head.
    heads.retain(|head| !head.is_empty());
    heads
}

fn first_word(text: &str) -> String {
    text.trim_start()
        .chars()
        .take_while(|character| is_word_character(*character))
        .collect()
}

fn has_word(code: &str, word: &str) -> bool {
    code.match_indices(word).any(|(start, _)| {
        !code[..start].ends_with(is_word_character)
            && !code[start + word.len()..].starts_with(is_word_character)
    })
}

fn is_word_character(character: char) -> bool {
    character.is_alphanumeric() || character == '_'
}

/// Returns all files below the folder, with '/' in their paths.
fn source_files(folder: &Path, below: &str) -> Vec<(String, String)> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = below.to_owned() + path.file_name().unwrap().to_str().unwrap();
        if path.is_dir() {
            files.extend(source_files(&path, &(name + "/")));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push((name, fs::read_to_string(&path).unwrap()));
        }
    }
    // Files of unit tests may use any module.
    files.retain(|(path, _)| !path.ends_with("/tests.rs"));
    files.sort();
    files
}

#[test]
fn the_source_keeps_to_its_architecture() {
    let files = source_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), "");
    // A checker that finds no files would report no violation.
    for expected in ["lib.rs", "scalar/mod.rs", "mesh/mod.rs", "contact/pair.rs"] {
        assert!(files.iter().any(|(path, _)| path == expected), "{expected}");
    }
    let violations = violations(&files);
    assert!(violations.is_empty(), "{}", violations.join("\n"));
}

fn violations_of(path: &str, text: &str) -> Vec<String> {
    violations(&[(path.to_owned(), text.to_owned())])
}

#[test]
fn downhill_imports_are_allowed() {
    let text =
        "use super::TetMesh;\nuse crate::geometry::Aabb;\nuse crate::{mesh, scalar::lift};\n";
    assert_eq!(violations_of("mesh/shapes/box.rs", text), [""; 0]);
    assert_eq!(
        violations_of("io/mod.rs", "use crate::gradient::X;\n"),
        [""; 0]
    );
    assert_eq!(violations_of("lib.rs", "pub use crate::io::X;\n"), [""; 0]);
}

#[test]
fn uphill_imports_are_found() {
    let uphill = ["mesh/surface.rs uses contact, which comes after it"];
    for text in [
        "use crate::contact::Shape;",
        "fn f(_: &crate::contact::Shape) {}",
        "pub(in crate::contact) fn f() {}",
        "use crate::{geometry::{Aabb, FACES}, contact::Shape};",
        "use crate::{\n    geometry::Aabb,\n    contact,\n};",
    ] {
        assert_eq!(violations_of("mesh/surface.rs", text), uphill, "{text}");
    }
}

#[test]
fn uphill_imports_through_super_are_found() {
    assert_eq!(
        violations_of("mesh/shapes/cuboid.rs", "use super::super::super::io::X;"),
        ["mesh/shapes/cuboid.rs climbs by super::super"]
    );
    assert_eq!(
        violations_of("scalar.rs", "use super::{spatial, scalar};"),
        ["scalar.rs uses spatial, which comes after it"]
    );
    assert_eq!(
        violations_of("mesh/mod.rs", "use super::io;"),
        ["mesh/mod.rs uses io, which comes after it"]
    );
    assert_eq!(
        violations_of("mesh/io.rs", "use super::io;"),
        [""; 0],
        "here super is mesh"
    );
}

#[test]
fn everything_is_downhill_of_io_alone() {
    for (rank, module) in MODULES.iter().enumerate() {
        let path = format!("{module}/x.rs");
        for (target_rank, target) in MODULES.iter().enumerate() {
            let violations = violations_of(&path, &format!("use crate::{target}::X;"));
            assert_eq!(violations.is_empty(), target_rank <= rank, "{violations:?}");
        }
    }
}

#[test]
fn modules_off_the_list_are_found() {
    assert_eq!(
        violations_of("rendering/mod.rs", ""),
        ["rendering/mod.rs belongs to rendering, which is not on the list of modules"]
    );
    assert_eq!(
        violations_of("rendering.rs", ""),
        ["rendering.rs belongs to rendering, which is not on the list of modules"]
    );
    assert_eq!(
        violations_of("mesh/mod.rs", "use crate::Everything;"),
        ["mesh/mod.rs uses crate::Everything, which is not on the list of modules"]
    );
}

#[test]
fn libraries_in_the_wrong_room_are_found() {
    for (path, text, library) in [
        ("contact/pair.rs", "use rstar::RTree;", "rstar"),
        ("contact/pair.rs", "use num_dual::Dual64;", "num_dual"),
        ("gradient/wrench.rs", "use num_dual::Dual64;", "num_dual"),
        ("gradient/batch.rs", "use rayon::prelude::*;", "rayon"),
        (
            "mesh/tet_mesh.rs",
            "let x = miniz_oxide::inflate();",
            "miniz_oxide",
        ),
        ("lib.rs", "pub use base64;", "base64"),
    ] {
        assert_eq!(
            violations_of(path, text),
            [format!("{path} uses {library}")]
        );
    }
    for (path, text) in [
        ("broad_phase/tree.rs", "use rstar::RTree;"),
        ("scalar.rs", "use num_dual::DualNum;"),
        ("io/vtk.rs", "use base64::Engine;"),
        ("contact/pair.rs", "let first_rstar_box = 1;"),
    ] {
        assert_eq!(violations_of(path, text), [""; 0]);
    }
}

#[test]
fn back_doors_between_the_worlds_are_found() {
    for back_door in BACK_DOORS {
        let text = format!("let y = x{back_door};");
        let message = format!("contact/pair.rs has {back_door}: use lift or real_part");
        assert_eq!(violations_of("contact/pair.rs", &text), [message]);
        assert_eq!(violations_of("scalar.rs", &text), [""; 0]);
    }
}

#[test]
fn empty_names_are_found() {
    assert_eq!(
        violations_of("mesh/utils.rs", ""),
        ["mesh/utils.rs is named utils"]
    );
    assert_eq!(
        violations_of("mesh/helpers/sort.rs", ""),
        ["mesh/helpers/sort.rs is named helpers"]
    );
    assert_eq!(violations_of("mesh/common_edge.rs", ""), [""; 0]);
}

#[test]
fn circles_of_files_are_found() {
    let files = [
        ("mesh/a.rs", "use super::b::B;\n"),
        ("mesh/b.rs", "use super::a::A;\n"),
    ];
    let violations = violations(&files.map(|(path, text)| (path.to_owned(), text.to_owned())));
    assert_eq!(
        violations,
        [
            "mesh/a.rs is in a circle of files: it imports mesh/b.rs",
            "mesh/b.rs is in a circle of files: it imports mesh/a.rs"
        ]
    );
}

#[test]
fn a_test_only_item_hides_nothing_below_it() {
    let text = "#[cfg(test)]\nuse std::fs;\nuse crate::contact::Shape;\n";
    assert_eq!(
        violations_of("mesh/surface.rs", text),
        ["mesh/surface.rs uses contact, which comes after it"]
    );
}

#[test]
fn comments_and_unit_tests_may_name_anything() {
    let text =
        "//! See [`crate::contact`].\n/// As rstar and [`super::super`]\nfn f() {} // .re()\n";
    let tests =
        "#[cfg(test)]\nmod tests {\n    use crate::contact::Shape;\n    use num_dual::Dual64;\n}\n";
    assert_eq!(
        violations_of("mesh/surface.rs", &(text.to_owned() + tests)),
        [""; 0]
    );
}
