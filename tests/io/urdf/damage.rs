//! Damaged texts are read or refused, without a panic.

use hydroelastic::io::urdf::{Robot, UrdfError};
use proptest::prelude::*;
use std::path::Path;

/// Words that a mutation inserts.
const WORDS: [&str; 16] = [
    "<",
    ">",
    "/>",
    "\"",
    "&",
    "nan",
    "inf",
    "-1",
    "0",
    "1e308",
    "1e-320",
    "<link name=\"a\"/>",
    "<joint/>",
    "<origin rpy=\"1e300 1 1\"/>",
    "]]>",
    "\u{FEFF}",
];

fn panda() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/robots");
    std::fs::read_to_string(folder.join("panda.urdf")).unwrap()
}

/// Boundary of a character at or before a byte.
fn boundary(text: &str, byte: usize) -> usize {
    let byte = byte % (text.len() + 1);
    let mut bytes = (0..=byte).rev();
    bytes.find(|&byte| text.is_char_boundary(byte)).unwrap_or(0)
}

/// Reads the text. A robot must be a tree in order, and an error must have a message.
fn check(text: &str) {
    match text.parse::<Robot>() {
        Ok(robot) => {
            assert_eq!(robot.links().len(), robot.joints().len() + 1);
            for (joint, child) in robot.joints().iter().zip(&robot.links()[1..]) {
                assert_eq!(joint.child, child.name);
            }
        }
        Err(error) => assert!(error.to_string().starts_with("line "), "{error}"),
    }
}

#[test]
fn truncated_texts_are_refused() {
    let text = panda();
    let end = text.trim_end().len();
    for length in (0..end).step_by(7) {
        let error = text[..boundary(&text, length)]
            .parse::<Robot>()
            .unwrap_err();
        assert!(matches!(error, UrdfError::Xml { .. }), "{error}");
    }
}

#[test]
fn texts_without_one_line_never_panic() {
    let text = panda();
    let lines: Vec<&str> = text.lines().collect();
    for skipped in 0..lines.len() {
        let kept = lines
            .iter()
            .enumerate()
            .filter(|(index, _)| *index != skipped);
        check(&kept.map(|(_, line)| *line).collect::<Vec<_>>().join("\n"));
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(
            proptest::test_runner::FileFailurePersistence::WithSource("regressions"),
        )),
        ..ProptestConfig::with_cases(500)
    })]

    #[test]
    fn mutated_texts_never_panic(
        mutations in prop::collection::vec((any::<usize>(), 0_usize..40, 0..WORDS.len()), 1..4)
    ) {
        let mut text = panda();
        for (byte, length, word) in mutations {
            let start = boundary(&text, byte);
            let end = boundary(&text, (start + length).min(text.len()));
            text.replace_range(start..end, WORDS[word]);
        }
        check(&text);
    }

    /// Replacements of whole values of attributes keep the XML intact, so that the reader sees more of them.
    #[test]
    fn mutated_values_never_panic(
        mutations in prop::collection::vec((any::<usize>(), 0..WORDS.len()), 1..4)
    ) {
        let text = panda();
        let mut parts: Vec<&str> = text.split('"').collect();
        for (part, word) in mutations {
            let count = parts.len();
            parts[part % (count / 2) * 2 + 1] = WORDS[word].trim_matches(['<', '&', '"', '>']);
        }
        check(&parts.join("\""));
    }
}

#[test]
fn entities_and_deep_elements_are_refused_or_ignored() {
    let deep = "<a>".repeat(100_000) + &"</a>".repeat(100_000);
    check(&format!("<robot name='arm'><link name='a'/>{deep}</robot>"));
    let entity = "<!DOCTYPE robot [<!ENTITY a 'aaaa'>]><robot name='&a;'><link name='a'/></robot>";
    let error = entity.parse::<Robot>().unwrap_err();
    assert!(matches!(error, UrdfError::Xml { .. }), "{error}");
}

#[test]
fn files_that_are_not_utf_8_are_refused_with_the_line() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("latin.urdf");
    std::fs::write(
        &path,
        b"<robot name='arm'>\n<!-- \xE9 -->\n<link name='a'/></robot>",
    )
    .unwrap();
    let error = Robot::read(&path).unwrap_err();
    assert!(
        matches!(&error, UrdfError::Xml { at, .. } if at.line == 2),
        "{error}"
    );
    let missing = Robot::read("no_such.urdf").unwrap_err();
    assert!(matches!(missing, UrdfError::Read { .. }), "{missing}");
}

#[test]
fn a_byte_order_mark_is_ignored() {
    assert!(
        "\u{FEFF}<robot name='arm'><link name='a'/></robot>"
            .parse::<Robot>()
            .is_ok()
    );
}
