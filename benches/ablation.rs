//! Table I of the paper: the wrench of two icospheres. Rows (a) to (e) switch on the optimizations of §IV of the paper one after the other.
//! Row (f) is the default of this library, which traces the contact surface.
//!
//! Helps to decide which culling steps are worth having, and whether tracing the surface should be the default. Run
//! `cargo bench --bench ablation`, or with `-- --quick` without order 4. Times are medians on one thread. Factors are relative to row (a).
//!
//! The paper names neither its scene nor its number of projections. The scene here is that of the authors' bench and unit test: radius 1,
//! center pressure 1, centers (0.031, −0.5, 0.052) and (0, 0.5, 0). The number of projections is 16. The paper's times are its printed
//! times of a Julia program on the authors' machine.

mod timing;

use hydroelastic::broad_phase::Projections;
use hydroelastic::contact::{ContactBody, ContactPair, Culling, Search, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, Vector6};
use std::hint::black_box;
use std::time::Duration;
use timing::{count, median_seconds, time, use_one_thread};

const CENTERS: [Vector3<f64>; 2] = [
    Vector3::new(0.031, -0.5, 0.052),
    Vector3::new(0.0, 0.5, 0.0),
];

/// Relative tolerance of wrenches, because the order of summation changes rounding errors.
const SAME: f64 = 1e-12;

const BUDGET: Duration = Duration::from_millis(500);

/// A row of the table.
struct Row {
    name: &'static str,
    search: Search,
    /// The paper's times (s) at orders 1, 2 and 3.
    paper: Option<[f64; 3]>,
}

/// Results of one row at one order.
struct Measured {
    seconds: f64,
    pairs: usize,
    polygons: usize,
    wrench_on_a: Vector6<f64>,
}

fn culling(switched_on: usize) -> Search {
    Search::Culling(Culling {
        bounding_boxes: switched_on >= 1,
        plane_check: switched_on >= 2,
        tree: switched_on >= 3,
        projections: if switched_on >= 4 {
            Projections::COUNT
        } else {
            0
        },
    })
}

fn rows() -> [Row; 6] {
    let paper = |name, switched_on, seconds| Row {
        name,
        search: culling(switched_on),
        paper: Some(seconds),
    };
    [
        paper("(a) all pairs", 0, [0.263, 3.77, 58.16]),
        paper("(b) + bounding boxes", 1, [0.077, 0.957, 14.52]),
        paper("(c) + plane check", 2, [0.071, 0.943, 13.71]),
        paper("(d) + R\\*-tree", 3, [0.041, 0.445, 5.30]),
        paper("(e) + projections", 4, [0.036, 0.368, 3.82]),
        Row {
            name: "(f) following",
            search: Search::Following,
            paper: None,
        },
    ]
}

fn measured(shape: &Shape, search: Search) -> Measured {
    let [a, b] = CENTERS.map(Pose::from_translation);
    let body = |pose| ContactBody::new(shape, pose, 1.0).unwrap();
    let pair = ContactPair::new(body(a), body(b)).with_search(search);
    let work = pair.work_count();
    Measured {
        seconds: median_seconds(BUDGET, || {
            black_box(black_box(&pair).wrench());
        }),
        pairs: work.candidate_pairs,
        polygons: work.polygons,
        wrench_on_a: pair.wrench().on_a.to_vector(),
    }
}

/// Measures all rows at one order and checks that their wrenches agree.
fn column(order: usize) -> Vec<Measured> {
    let shape = Shape::new(shapes::icosphere(1.0, order).unwrap());
    let column: Vec<_> = rows()
        .iter()
        .map(|row| measured(&shape, row.search))
        .collect();
    let expected = column[0].wrench_on_a;
    for (row, point) in rows().iter().zip(&column) {
        let error = (point.wrench_on_a - expected).amax() / expected.amax();
        assert!(error <= SAME, "{} at order {order}: {error:e}", row.name);
        assert_eq!(point.polygons, column[0].polygons, "{}", row.name);
    }
    column
}

fn print_times(orders: &[usize], columns: &[Vec<Measured>]) {
    let titles = orders.iter().map(|order| format!("order {order}"));
    let of_paper = (1..=3).map(|order| format!("paper, order {order}"));
    print_header("", titles.chain(of_paper));
    for (index, row) in rows().iter().enumerate() {
        let ours = columns.iter().map(|column| {
            let (seconds, slowest) = (column[index].seconds, column[0].seconds);
            with_factor(&time(seconds), slowest / seconds)
        });
        let of_paper = (0..3).map(|order| match (row.paper, rows()[0].paper) {
            (Some(seconds), Some(slowest)) => {
                with_factor(&as_printed(seconds[order]), slowest[order] / seconds[order])
            }
            _ => String::new(),
        });
        print_row(row.name, ours.chain(of_paper));
    }
}

fn print_counts(orders: &[usize], columns: &[Vec<Measured>]) {
    let title = |order: &usize| format!("order {order} ({} tets each)", count(20 << (2 * order)));
    print_header("", orders.iter().map(title));
    for (index, row) in rows().iter().enumerate() {
        let pairs = columns.iter().map(|column| count(column[index].pairs));
        print_row(row.name, pairs);
    }
    let polygons = columns.iter().map(|column| count(column[0].polygons));
    print_row("contact polygons", polygons);
}

/// Formats a time (s) with as many digits as in the paper.
fn as_printed(seconds: f64) -> String {
    let digits = if seconds < 1.0 { 3 } else { 2 };
    format!("{seconds:.digits$} s")
}

fn with_factor(time: &str, factor: f64) -> String {
    match factor {
        1.0 => time.to_owned(),
        f if f < 100.0 => format!("{time} ({f:.1}×)"),
        f => format!("{time} ({}×)", count(f)),
    }
}

fn print_header(corner: &str, titles: impl Iterator<Item = String>) {
    let titles: Vec<_> = titles.collect();
    print_row(corner, titles.iter().cloned());
    print_row("---", titles.iter().map(|_| "---".to_owned()));
}

fn print_row(name: &str, cells: impl Iterator<Item = String>) {
    let cells: Vec<_> = cells.collect();
    println!("| {name} | {} |", cells.join(" | "));
}

fn main() {
    use_one_thread();
    // `cargo test` runs benches too, without `--bench`. The bench is then quick.
    let is_asked = |argument: &str| std::env::args().any(|present| present == argument);
    let is_quick = is_asked("--quick") || !is_asked("--bench");
    let orders: &[usize] = if is_quick { &[1, 2, 3] } else { &[1, 2, 3, 4] };
    let columns: Vec<_> = orders.iter().map(|&order| column(order)).collect();
    print_times(orders, &columns);
    println!("\npairs of tetrahedra looked at\n");
    print_counts(orders, &columns);
    println!("\nall rows give the same wrench to {SAME:e}");
}
