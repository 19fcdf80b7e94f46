//! Minimum times (µs) of one contact in Rust, for comparison with `tests/times.py`.

use hydroelastic::contact::{ContactBody, ContactPair, Shape, SurfaceLaw};
use hydroelastic::mesh::shapes;
use hydroelastic::nalgebra::{self, Vector6, vector};
use hydroelastic::spatial::{Pose, Twist};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

fn least<O>(count: usize, job: impl Fn() -> O) -> f64 {
    let time = || {
        let start = Instant::now();
        black_box(job());
        start.elapsed().as_secs_f64() * 1e6
    };
    (0..count).map(|_| time()).fold(f64::INFINITY, f64::min)
}

fn main() -> Result<(), Box<dyn Error>> {
    let block = Shape::new(shapes::cuboid([0.4, 0.4, 0.2])?);
    let pose_a =
        Pose::from_rotation_vector(&vector![0.3, -0.2, 0.5], vector![0.013, 0.021, 0.1921]);
    let pose_b = Pose::from_rotation_vector(&vector![0.02, -0.03, 0.01], vector![0.0, 0.0, 0.0]);
    let law = SurfaceLaw::new(0.2, 0.4, 1e-2)?;
    let twist = Twist::from_vector(&Vector6::new(0.1, 0.2, -0.3, 0.5, 0.1, -0.05));
    for order in 1..=4 {
        let ball = Shape::new(shapes::icosphere(0.1, order)?);
        let pair = || -> Result<_, Box<dyn Error>> {
            let a = ContactBody::new(&ball, pose_a, 1e5)?;
            Ok(ContactPair::new(a, ContactBody::new(&block, pose_b, 1e6)?))
        };
        println!(
            "order {order}: wrench {:.2}, with Jacobian {:.2}, in motion {:.2}, linearized {:.2}",
            least(3000, || pair().map(|it| it.wrench())),
            least(3000, || pair().map(|it| it.linearized())),
            least(3000, || pair()
                .map(|it| it.moving(law, [twist; 2]).wrench())),
            least(3000, || pair()
                .map(|it| it.moving(law, [twist; 2]).linearized())),
        );
    }
    Ok(())
}
