//! Files whose writing fails halfway: a full disk, a killed process, a rollout that ends early.
#![cfg(unix)]

use crate::support::worlds::{at, cuboid, dynamic, falling, fixed, icosphere};
use hydroelastic::contact::{ContactBody, ContactPair};
use hydroelastic::dynamics::{Material, Plan, State, Trajectory, World};
use hydroelastic::io::{FileError, Recording, TrajectoryFile, write_surface, write_trajectory};
use std::fs::{self, DirEntry};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, io, thread};

const TIME_STEP: f64 = 1e-3;

/// Returns a ball that falls on a floor and hits it after about 45 steps.
fn world(skin: Material) -> World {
    let ball = icosphere(0.1, 1);
    let ball = dynamic("ball", ball, skin, 1.0);
    let floor = cuboid([1.0, 1.0, 0.2]);
    let floor = fixed("floor", floor, skin);
    falling(vec![
        ball.with_pose(at(0.0, 0.0, 0.11)),
        floor.with_pose(at(0.0, 0.0, -0.1)),
    ])
}

fn soft_world() -> World {
    world(Material::elastic(1e5).with_friction(0.4))
}

/// Environment variable with the file that a child process of this program writes. The child process is expected to fail.
const FILE: &str = "HYDROELASTIC_FILE_TO_FAIL";

/// Returns a command that runs one of these tests in a child process, with a file to write, under the limits of a shell command.
fn process(test: &str, limits: &str, file: &Path) -> Command {
    let mut shell = Command::new("sh");
    let run = format!("{limits} exec \"$0\" \"$@\"");
    shell.args(["-c", &run]);
    shell.arg(env::current_exe().unwrap());
    let (_, module) = module_path!().split_once("::").unwrap();
    shell.args([&format!("{module}::{test}"), "--exact"]);
    shell.env(FILE, file);
    shell
}

/// Returns the file to write, if this is a child process.
fn file_to_write() -> Option<PathBuf> {
    env::var_os(FILE).map(PathBuf::from)
}

/// Creates an empty folder.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir(&folder).unwrap();
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let name = |entry: io::Result<DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    entries.map(name).collect()
}

/// Names of files, one for each kind that is written atomically.
const WHOLE: &[&str] = if cfg!(feature = "parquet") {
    &["a.csv", "a.glb", "a.vtp", "a.vtk", "a.parquet"]
} else {
    &["a.csv", "a.glb", "a.vtp", "a.vtk"]
};

fn recorded(world: &World) -> Trajectory {
    let rollout = world.rollout(&Plan::new(TIME_STEP, 300).unwrap());
    rollout.run().unwrap()
}

/// Writes a file of more than 16 KiB.
fn write(path: &Path) -> Result<(), FileError> {
    let world = soft_world();
    match path.extension().unwrap().to_str().unwrap() {
        "csv" | "parquet" => write_trajectory(path, &world, &recorded(&world)),
        "glb" => Recording::new(&world, &recorded(&world)).write(path),
        _ => {
            let ball = icosphere(1.0, 3);
            let body = |x| {
                let pose = at(x, 0.0, 0.0);
                ContactBody::new(&ball, pose, 1e5).unwrap()
            };
            write_surface(path, &ContactPair::new(body(0.0), body(0.3)).surface())
        }
    }
}

/// Shell command that limits file sizes, like a full disk, to 8 or 16 KiB, depending on the units of the shell.
const FULL: &str = "trap '' XFSZ; ulimit -f 16;";

/// Shell command with the same limit that kills the process when it exceeds the limit.
const KILLED: &str = "ulimit -f 16; ulimit -c 0;";

#[test]
fn on_a_full_disk_a_file_stays_as_it_was() {
    if let Some(file) = file_to_write() {
        let FileError::Write { path, source } = write(&file).unwrap_err() else {
            panic!("expected a write error")
        };
        assert_eq!(path, file);
        assert_eq!(source.kind(), io::ErrorKind::FileTooLarge);
        return;
    }
    let folder = folder("full_disk");
    for name in WHOLE {
        let file = folder.join(name);
        for before in [None, Some(b"an older file")] {
            if let Some(before) = before {
                fs::write(&file, before).unwrap();
            }
            let test = "on_a_full_disk_a_file_stays_as_it_was";
            let ended = process(test, FULL, &file).output().unwrap();
            assert!(ended.status.success(), "{ended:?}");
            let after = fs::read(&file).ok();
            assert_eq!(after.as_deref(), before.map(|before| &before[..]), "{name}");
            // The folder has no other file.
            assert_eq!(names(&folder).len(), usize::from(before.is_some()));
        }
        fs::remove_file(&file).unwrap();
    }
}

#[test]
fn a_process_killed_while_it_writes_leaves_a_file_as_it_was() {
    if let Some(file) = file_to_write() {
        write(&file).unwrap();
        return;
    }
    let folder = folder("killed");
    for name in WHOLE {
        let file = folder.join(name);
        fs::write(&file, b"an older file").unwrap();
        let test = "a_process_killed_while_it_writes_leaves_a_file_as_it_was";
        let ended = process(test, KILLED, &file).output().unwrap();
        // The signal is SIGXFSZ, sent while the process wrote a draft.
        assert_eq!(ended.status.signal(), Some(25), "{ended:?}");
        assert_eq!(fs::read(&file).unwrap(), b"an older file");
        assert_eq!(names(&folder).len(), 2, "{:?}", names(&folder));
        let is_draft = |name: &&String| name.starts_with("hydroelastic-");
        let draft = names(&folder).iter().find(is_draft).unwrap().clone();
        let written = fs::metadata(folder.join(&draft)).unwrap().len();
        assert!(written > 0);
        fs::remove_file(folder.join(draft)).unwrap();
        // The file can be written normally afterwards.
        write(&file).unwrap();
        assert!(fs::metadata(&file).unwrap().len() > written);
        assert_eq!(names(&folder), [*name]);
        fs::remove_file(&file).unwrap();
    }
}

#[test]
fn what_is_left_of_a_rollout_can_be_written() {
    let world = world(Material::elastic(1e150).with_dissipation(1e150));
    let rollout = world.rollout(&Plan::new(TIME_STEP, 1_000).unwrap());
    let interrupted = rollout.run().unwrap_err();
    let folder = folder("interrupted");
    let (table, recording) = (folder.join("a.csv"), folder.join("a.glb"));
    write_trajectory(&table, &world, &interrupted.trajectory).unwrap();
    assert_is_table_of(&table, interrupted.trajectory.states());
    let shown = Recording::new(&world, &interrupted.trajectory);
    shown.write(&recording).unwrap();
    assert!(fs::read(recording).unwrap().starts_with(b"glTF"));
}

/// Asserts that the complete lines of a table are those of these states from the first on, and returns the number of complete states.
fn whole_states(file: &Path, states: impl IntoIterator<Item = State>) -> usize {
    let text = fs::read_to_string(file).unwrap();
    let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
    let mut reader = csv::Reader::from_reader(whole.as_bytes());
    let mut rows = reader.records().map(Result::unwrap);
    let bodies = states.into_iter().flat_map(|state| {
        let bodies = ["ball", "floor"].into_iter().zip(state.bodies);
        bodies.map(move |(name, body)| (state.time, name, body))
    });
    let mut count = 0;
    for (row, (time, name, body)) in rows.by_ref().zip(bodies) {
        let number = |column: usize| row[column].parse::<f64>().unwrap().to_bits();
        assert_eq!((number(0), &row[1]), (time.to_bits(), name));
        assert_eq!(row.len(), 15);
        for axis in 0..3 {
            assert_eq!(number(2 + axis), body.position()[axis].to_bits());
            assert_eq!(number(9 + axis), body.velocity()[axis].to_bits());
            assert_eq!(number(12 + axis), body.twist.angular[axis].to_bits());
        }
        count += 1;
    }
    assert!(rows.next().is_none());
    count / 2
}

fn assert_is_table_of(file: &Path, states: &[State]) {
    let text = fs::read_to_string(file).unwrap();
    assert!(text.ends_with('\n'));
    assert_eq!(whole_states(file, states.iter().cloned()), states.len());
}

/// Yields the initial state and all later states without end.
fn states(world: &World) -> impl Iterator<Item = State> {
    let rollout = world.rollout(&Plan::new(TIME_STEP, 0).unwrap());
    let initial = std::iter::once(world.initial_state());
    initial.chain(rollout.map(Result::unwrap))
}

#[test]
fn a_growing_file_is_the_table_of_the_trajectory() {
    let (world, folder) = (soft_world(), folder("growing"));
    let (growing, whole) = (folder.join("growing.csv"), folder.join("whole.CSV"));
    let mut file = TrajectoryFile::create_new(&growing, &world).unwrap();
    for (count, state) in states(&world).take(301).enumerate() {
        assert_eq!(whole_states(&growing, states(&world).take(count)), count);
        file.push(&state).unwrap();
    }
    file.sync().unwrap();
    write_trajectory(&whole, &world, &recorded(&world)).unwrap();
    assert_eq!(fs::read(growing).unwrap(), fs::read(whole).unwrap());
}

#[test]
fn a_growing_file_takes_no_other_name_place_or_world() {
    let (world, folder) = (soft_world(), folder("refused"));
    let path = folder.join("a.parquet");
    let error = TrajectoryFile::create_new(&path, &world).unwrap_err();
    let message = error.to_string();
    let expected = r#"ends in "parquet", but has to end in one of ["csv"]"#;
    assert!(message.ends_with(expected), "{message}");
    let path = folder.join("a.csv");
    fs::write(&path, b"an older file").unwrap();
    let error = TrajectoryFile::create_new(&path, &world).unwrap_err();
    let FileError::Write { source, .. } = error else {
        panic!("{error}")
    };
    assert_eq!(source.kind(), io::ErrorKind::AlreadyExists);
    assert_eq!(fs::read(&path).unwrap(), b"an older file");
    fs::remove_file(&path).unwrap();
    let mut file = TrajectoryFile::create_new(&path, &world).unwrap();
    let mut state = world.initial_state();
    file.push(&state).unwrap();
    state.bodies.truncate(1);
    let error = file.push(&state).unwrap_err();
    let is_other = |error| {
        matches!(
            error,
            FileError::OtherWorld {
                found: 1,
                expected: 2,
                ..
            }
        )
    };
    assert!(is_other(error));
    assert_is_table_of(&path, &[world.initial_state()]);
}

#[test]
fn on_a_full_disk_a_growing_file_ends_with_the_last_whole_state() {
    let world = soft_world();
    if let Some(path) = file_to_write() {
        let mut file = TrajectoryFile::create_new(&path, &world).unwrap();
        let mut pushed = states(&world).map(|state| file.push(&state));
        let count = pushed.by_ref().take_while(Result::is_ok).count();
        let error = pushed.next().unwrap().unwrap_err();
        let FileError::Write {
            path: named,
            source,
        } = error
        else {
            panic!("{error}")
        };
        assert_eq!(named, path);
        assert_eq!(source.kind(), io::ErrorKind::FileTooLarge);
        let written: Vec<State> = states(&world).take(count).collect();
        assert_is_table_of(&path, &written);
        return;
    }
    let path = folder("full_disk_growing").join("a.csv");
    let test = "on_a_full_disk_a_growing_file_ends_with_the_last_whole_state";
    let ended = process(test, FULL, &path).output().unwrap();
    assert!(ended.status.success(), "{ended:?}");
    // Rows are shorter than 300 bytes.
    assert!(whole_states(&path, states(&world)) > 8_192 / 600 - 2);
}

/// Size (bytes) at which a file is cut off, and time limit (s) to reach this size.
const ENOUGH: u64 = 100_000;
const PATIENCE: u64 = 120;

#[test]
fn a_killed_process_leaves_what_it_has_pushed() {
    let world = soft_world();
    if let Some(path) = file_to_write() {
        let mut file = TrajectoryFile::create_new(&path, &world).unwrap();
        states(&world).for_each(|state| file.push(&state).unwrap());
    }
    let path = folder("killed_growing").join("a.csv");
    let test = "a_killed_process_leaves_what_it_has_pushed";
    let mut process = process(test, "", &path)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let start = Instant::now();
    let is_long = || fs::metadata(&path).is_ok_and(|file| file.len() > ENOUGH);
    while !is_long() && start.elapsed().as_secs() < PATIENCE {
        thread::sleep(Duration::from_millis(1));
    }
    process.kill().unwrap();
    process.wait().unwrap();
    assert!(is_long());
    let count = whole_states(&path, states(&world));
    assert!(count as u64 > ENOUGH / 600, "{count}");
}
