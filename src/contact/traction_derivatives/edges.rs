//! The faces that move the edges of a special polygon, and their shares.

use super::lines::{Line, Lines, TAXEL_PLANE, inverse_sine, split_between_owners};
use super::pieces::EdgeFace;
use crate::contact::outline::at;
use crate::contact::plane_polygon::PlanePolygon;
use crate::contact::polygon_source::PolygonSource;
use crate::friction::ends;
use crate::geometry::set_bits;
use crate::narrow_phase::{Cut, PERTURBATION, Weights};
use nalgebra::{Matrix3, Vector3};

/// The edges of a contact polygon, with the data that determines how they move.
pub(in crate::contact) struct Edges<'e> {
    source: &'e PolygonSource<'e, f64>,
    cut: &'e Cut,
    polygon: &'e PlanePolygon<f64>,
    /// e₁, e₂ and n as columns.
    axes: Matrix3<f64>,
    /// Speed of the plane along its normal if B moves with the velocity [`PERTURBATION`] (m/s).
    plane_speed: f64,
    /// Speed of the plane along its normal, per pressure, if the modulus of B grows at the relative rate of 1/s (m/(s Pa)).
    by_pressure: f64,
}

/// A degenerate polygon is a line, traversed forth and back. Edges shorter than this fraction of its longest edge are the ends of the line,
/// and all others are its sides.
const SHORTEST_SIDE: f64 = 1e-6;

impl<'e> Edges<'e> {
    pub fn of(
        source: &'e PolygonSource<'e, f64>,
        (cut, polygon): (&'e Cut, &'e PlanePolygon<f64>),
    ) -> Self {
        let plane = &polygon.plane;
        Self {
            source,
            cut,
            polygon,
            axes: Matrix3::from_columns(&plane.axes.map(Vector3::from)),
            plane_speed: -Vector3::from(plane.slopes[1]).dot(&PERTURBATION),
            by_pressure: plane.inverse_gradient_norm,
        }
    }

    /// Appends the faces that move edges, each with the index of its edge. Edges on A's boundary are omitted, because the pressure is zero
    /// there.
    pub fn list(&self, faces: &mut Vec<(usize, EdgeFace)>) {
        self.visit_loaded(|edge, owners| {
            self.visit_faces((edge, owners), None, |face| faces.push((edge, face)));
        });
    }

    /// Visits the moving edges, each with its owners as bits. Edges on A's boundary are omitted, because the pressure is zero there.
    pub fn visit_loaded(&self, visit: impl FnMut(usize, u8)) {
        let boundary = self.source.pair.tet_a(self.cut.tets[0]).zero_faces;
        self.visit(boundary, visit);
    }

    /// Visits the moving edges, each with its owners. Edges that lie in one of the faces `skipped` are omitted. Sets of faces are given as
    /// bits.
    fn visit(&self, skipped: u8, mut visit: impl FnMut(usize, u8)) {
        let mut visit_edge = |edge: usize, owners: u8| {
            if owners != 0 && owners & skipped == 0 {
                visit(edge, owners);
            }
        };
        if let Some((edge, owners)) = self.degenerate_side() {
            return visit_edge(edge, owners);
        }
        for (edge, &owners) in self.owners().iter().enumerate() {
            if self.length_squared(edge) > 0.0 {
                visit_edge(edge, owners);
            }
        }
    }

    /// Visits the owners of an edge, with their shares in the motion of the edge. Owners without a share are omitted. If the edge also lies
    /// in a plane of taxels, the plane shares the edge. `plane` has its outward normal and its body, as in [`EdgeFace`].
    pub fn visit_faces(
        &self,
        (edge, owners): (usize, u8),
        plane: Option<(Vector3<f64>, u8)>,
        mut visit: impl FnMut(EdgeFace),
    ) {
        let Weights { still, moving } = self.cut.weights();
        if owners.is_power_of_two() && plane.is_none() {
            let line = self.line(owners.trailing_zeros() as usize, edge);
            return visit(line.as_edge_face([moving.mean(), still.mean()]));
        }
        let mut lines = self.lines(edge, owners);
        lines[TAXEL_PLANE] = plane.map(|plane| self.line_of(TAXEL_PLANE, plane, edge));
        let mut shares = [[0.0; 2]; TAXEL_PLANE + 1];
        let face_speed = |line: &Line| f64::from(line.body) * line.outward.dot(&PERTURBATION);
        let speed = |line: &Line| face_speed(line) - self.plane_speed * line.along_normal;
        let size = PERTURBATION.norm();
        split_between_owners(
            &lines,
            (speed, size),
            moving.ahead_and_behind(),
            |line, share| {
                shares[line.face][0] += share;
            },
        );
        let [from, to] = self.polygon.ends(edge);
        let middle = [0, 1].map(|i| 0.5 * (from[i] + to[i]));
        let plane_speed = self.by_pressure * at(&self.polygon.plane.pressure, &middle);
        let growth = |line: &Line| -plane_speed * line.along_normal;
        let size = plane_speed.abs();
        split_between_owners(
            &lines,
            (growth, size),
            still.ahead_and_behind(),
            |line, share| {
                shares[line.face][1] += share;
            },
        );
        for line in lines.iter().flatten() {
            let shares = shares[line.face];
            if shares.iter().any(|&share| share != 0.0) {
                visit(line.as_edge_face(shares));
            }
        }
    }

    fn owners(&self) -> &[u8] {
        &self.cut.polygon.owners()[..self.polygon.outline.corners().len()]
    }

    fn length_squared(&self, edge: usize) -> f64 {
        let [y1, y2] = self.polygon.edge(edge);
        y1 * y1 + y2 * y2
    }

    /// Returns the longest side of a degenerate polygon, and the owners of all its sides (see [`SHORTEST_SIDE`]). A polygon with shared
    /// edges is degenerate if the normal of an owner points into the polygon. Returns `None` for other polygons.
    fn degenerate_side(&self) -> Option<(usize, u8)> {
        if !self.polygon.shares_edges {
            return None;
        }
        let owners = self.owners();
        let length = |edge: &usize| self.length_squared(*edge);
        let by_length = |a: &usize, b: &usize| length(a).total_cmp(&length(b));
        let longest = (0..owners.len()).max_by(by_length)?;
        let least = SHORTEST_SIDE * SHORTEST_SIDE * length(&longest);
        let long_edges = || (0..owners.len()).filter(|edge| length(edge) > least);
        let has_owner_inside = |edge: usize| {
            let lines = self.lines(edge, owners[edge]);
            lines.iter().flatten().any(|line| line.inverse_sine < 0.0)
        };
        long_edges().find(|&edge| has_owner_inside(edge))?;
        Some((
            longest,
            long_edges().fold(0, |all, edge| all | owners[edge]),
        ))
    }

    fn line(&self, face: usize, edge: usize) -> Line {
        let pair = &self.source.pair;
        let outward = if face < 4 {
            let a = pair.tet_a(self.cut.tets[0]);
            a.barycentric[face].gradient * -a.barycentric_steepness[face].recip()
        } else {
            let (b, face) = (pair.tet_b(self.cut.tets[1]), face - 4);
            let in_b = b.barycentric[face].gradient * -b.barycentric_steepness[face].recip();
            self.source.pose_ab.rotation() * in_b
        };
        self.line_of(face, (outward, u8::from(face >= 4)), edge)
    }

    /// Returns the line of a face or of a plane of taxels, from its outward normal and the body with which it moves.
    fn line_of(&self, face: usize, (outward, body): (Vector3<f64>, u8), edge: usize) -> Line {
        let normal = self.axes.tr_mul(&outward);
        Line {
            face,
            body,
            outward,
            along_normal: normal.z,
            inverse_sine: inverse_sine(&self.polygon.edge(edge), &normal),
        }
    }

    /// Returns the lines of the faces that own an edge. A face is omitted if the rounding error of its line is greater than the length of
    /// the edge, because the motion of the face says nothing about so short an edge.
    fn lines(&self, edge: usize, owners: u8) -> Lines {
        let length = self.length_squared(edge).sqrt();
        let margin = self.source.pair.margin();
        let mut lines = [None; TAXEL_PLANE + 1];
        for (slot, face) in lines.iter_mut().zip(set_bits(owners)) {
            let line = self.line(face, edge);
            *slot = (margin * line.inverse_sine.abs() <= length).then_some(line);
        }
        lines
    }
}

impl PlanePolygon<f64> {
    /// Returns the vector from the start of an edge of the contact polygon to its end.
    fn edge(&self, edge: usize) -> [f64; 2] {
        let [from, to] = self.ends(edge);
        [to[0] - from[0], to[1] - from[1]]
    }

    /// Returns the corners that an edge of the contact polygon joins.
    pub fn ends(&self, edge: usize) -> [[f64; 2]; 2] {
        ends(self.outline.corners(), edge)
    }
}

#[cfg(test)]
mod tests {
    use super::super::linearize::THREE_POINTS;
    use super::*;
    use crate::contact::{ContactBody, ContactPair, ContactWrench, Partner, Shape, SurfaceLaw};
    use crate::mesh::shapes;
    use crate::spatial::{Pose, Twist};
    use nalgebra::{Matrix3, SMatrix};
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};

    /// Round-off of fluxes through edges that cancel, relative to the largest entry.
    const EXACT: f64 = 1e-11;

    /// Rounding and curvature of central differences with this step (m), relative to the largest entry.
    const DIFFERENCES: f64 = 1e-6;
    const STEP: f64 = 1e-5;

    /// Calls `check` with touching pairs at random poses, with A at the world's origin.
    fn for_pairs(count: usize, mut check: impl FnMut(&ContactPair)) {
        let shapes = [
            shapes::icosphere(1.0, 1),
            shapes::ellipsoid([0.6, 0.8, 1.1], 2),
            shapes::cuboid([1.0, 1.4, 0.8]),
            shapes::distance_cuboid([1.2, 0.8, 1.0]),
        ]
        .map(|field| Shape::new(field.unwrap()));
        let mut random = StdRng::seed_from_u64(61);
        let mut checked = 0;
        while checked < count {
            let [a, b] = [0, 1].map(|_| &shapes[random.random_range(0..shapes.len())]);
            let mut vector = |size: f64| Vector3::from_fn(|_, _| random.random_range(-size..size));
            let pose = Pose::from_rotation_vector(&vector(1.5), vector(0.8));
            let pair = ContactPair::new(
                ContactBody::new(a, Pose::identity(), 1.0).unwrap(),
                ContactBody::new(b, pose, 1.7).unwrap(),
            );
            if !pair.surface().is_empty() {
                check(&pair);
                checked += 1;
            }
        }
    }

    fn all_cuts(pair: &ContactPair) -> Vec<Cut> {
        pair.cut_surface()
            .sum_of_cuts(|cuts: &mut Vec<_>, cut| cuts.push(*cut))
    }

    /// If the pressure is clamped everywhere, the contribution of the law is minus the elastic contact. The law is integrated over areas
    /// and along edges, and the elastic contact only from moments.
    #[test]
    fn surfaces_that_part_quickly_have_no_wrench_and_no_derivatives() {
        let law = SurfaceLaw::new(1e6, 0.5, 1e-2).unwrap();
        let (mut worst, mut checked) = (0.0_f64, 0);
        for_pairs(300, |pair| {
            let normals: Vec<_> = pair.surface().polygons.iter().map(|p| p.normal).collect();
            let apart = normals.iter().sum::<Vector3<f64>>().normalize();
            if normals.iter().any(|normal| normal.dot(&apart) < 1e-3) {
                return;
            }
            let linear = Twist {
                angular: Vector3::zeros(),
                linear: apart,
            };
            let moving = pair.moving(law, [linear, Twist::zero()]).linearized();
            let elastic = pair.linearized();
            assert!(moving.kinks.are_clamped);
            let errors = [
                moving.by_poses.amax() / elastic.by_poses.amax(),
                moving.by_moduli.amax() / elastic.by_moduli.amax(),
                moving.wrench.on_a.to_vector().amax() / elastic.wrench.on_a.to_vector().amax(),
            ];
            worst = errors.into_iter().fold(worst, f64::max);
            assert!(moving.by_twists.amax() == 0.0 && moving.by_law.amax() == 0.0);
            checked += 1;
        });
        println!("worst of {checked}: {worst:.1e}");
        assert!(checked > 100 && worst <= EXACT, "{checked}, {worst:e}");
    }

    #[test]
    fn a_damping_that_is_not_finite_is_not_taken_for_clamped_pressure() {
        let ball = Shape::new(shapes::icosphere(1.0, 1).unwrap());
        let pose = Pose::from_translation(Vector3::new(0.0, 0.0, 0.9));
        let body = ContactBody::new(&ball, pose, 1.0).unwrap();
        let ground = Partner::rigid_half_space(Pose::identity()).unwrap();
        let law = SurfaceLaw::new(1e200, 0.3, 1e-2).unwrap();
        let apart = Twist {
            angular: Vector3::zeros(),
            linear: Vector3::new(0.0, 0.0, 1e200),
        };
        let pair = ContactPair::new(body, ground).moving(law, [apart, Twist::zero()]);
        let is_finite = |wrench: ContactWrench| wrench.on_a.force.iter().all(|f| f.is_finite());
        assert!(!is_finite(pair.wrench()) && !is_finite(pair.linearized().wrench));
    }

    /// The damping is exactly zero along an edge and negative elsewhere, so there is no wrench. The edge must not count twice.
    #[test]
    fn an_edge_at_which_the_damping_is_zero_counts_once() {
        let cube = Shape::new(shapes::cuboid([3.0; 3]).unwrap());
        let pose = Pose::from_translation(Vector3::new(0.0, 0.0, 1.125));
        let body = ContactBody::new(&cube, pose, 1.0).unwrap();
        let ground = Partner::rigid_half_space(Pose::identity()).unwrap();
        let law = SurfaceLaw::new(1.0, 0.0, 1e-2).unwrap();
        let apart = Twist {
            angular: Vector3::y(),
            linear: Vector3::new(0.0, 0.0, 2.125),
        };
        let by_height = |pair: ContactPair| pair.linearized().by_poses.column(5).amax();
        let pair = ContactPair::new(body, ground);
        let error = by_height(pair.moving(law, [apart, Twist::zero()])) / by_height(pair);
        assert!(error <= EXACT, "{error:e}");
    }

    /// Returns the area (m²), ∫ p dA and ∫ p x dA, from the contact surface.
    fn integrals(pair: &ContactPair) -> SMatrix<f64, 5, 1> {
        let surface = pair.surface();
        let center = surface.center_of_pressure().unwrap();
        let total: f64 = surface.polygons.iter().map(|p| p.pressure * p.area).sum();
        let weighted = center * total;
        SMatrix::from([[surface.area(), total, weighted.x, weighted.y, weighted.z]])
    }

    /// Returns the derivatives of [`integrals`] with respect to the position of B: the derivatives of the interior, and the flux of 1, p
    /// and p x through the edges.
    fn integral_rates(pair: &ContactPair) -> SMatrix<f64, 5, 3> {
        let (source, mut rates) = (pair.source(), SMatrix::<f64, 5, 3>::zeros());
        for cut in &all_cuts(pair) {
            let polygon = source.polygon(cut).unwrap();
            let plane = &polygon.plane;
            let [e1, e2, n] = plane.axes.map(Vector3::from);
            let by_position = -Vector3::from(plane.slopes[1]);
            let slope = plane.slope_along_normal();
            let [area, y1, y2, ..] = plane.moments;
            let first = Vector3::from(plane.origin) * area + e1 * y1 + e2 * y2;
            let weighted = first * slope + n * polygon.load();
            let inner = [0.0, slope * area, weighted.x, weighted.y, weighted.z];
            rates += SMatrix::<f64, 5, 1>::from([inner]) * by_position.transpose();
            let edges = Edges::of(&source, (cut, &polygon));
            edges.visit(0, |edge, owners| {
                edges.visit_faces((edge, owners), None, |by| {
                    let along_normal = by.normal.dot(&n);
                    let sine = (by.normal - n * along_normal).norm();
                    let own_normal = by.normal * f64::from(by.body);
                    let speed = (own_normal - by_position * along_normal) * (by.shares[0] / sine);
                    rates += flux(&polygon, edge) * speed.transpose();
                });
            });
        }
        rates
    }

    /// Returns ∫ 1, p and p x dl along an edge.
    fn flux(polygon: &PlanePolygon<f64>, edge: usize) -> SMatrix<f64, 5, 1> {
        let [from, to] = polygon.ends(edge);
        let [d1, d2] = polygon.edge(edge);
        let mut sum = SMatrix::<f64, 5, 1>::zeros();
        for (share, weight) in THREE_POINTS {
            let y = [0, 1].map(|i| from[i] + share * (to[i] - from[i]));
            let x = polygon.point(y);
            let p = at(&polygon.plane.pressure, &y);
            let point = SMatrix::from([[1.0, p, p * x.x, p * x.y, p * x.z]]);
            sum += point * (weight * d1.hypot(d2));
        }
        sum
    }

    #[test]
    fn area_and_center_of_pressure_move_by_the_same_fluxes() {
        let mut worst = [0.0_f64; 2];
        for_pairs(100, |pair| {
            let moved = |axis: usize, step: f64| {
                let position =
                    pair.b().pose().translation() + Matrix3::identity().column(axis) * step;
                let pose = pair.b().pose().with_translation(position);
                let b = pair.b().with(pose, |modulus| modulus);
                integrals(&ContactPair::new(*pair.a(), b))
            };
            let (rates, here) = (integral_rates(pair), integrals(pair));
            let center = |of: &SMatrix<f64, 5, 1>| of.fixed_rows::<3>(2) / of[1];
            for axis in 0..3 {
                let [ahead, behind] = [STEP, -STEP].map(|step| moved(axis, step));
                let rate = rates.column(axis);
                let area = (ahead - behind)[0] / (2.0 * STEP);
                worst[0] = worst[0].max((rate[0] - area).abs() / rates.row(0).amax());
                let actual = (rate.fixed_rows::<3>(2) - center(&here) * rate[1]) / here[1];
                let expected = (center(&ahead) - center(&behind)) / (2.0 * STEP);
                worst[1] = worst[1].max((actual - expected).amax());
            }
        });
        println!(
            "worst: area {:.1e}, center of pressure {:.1e}",
            worst[0], worst[1]
        );
        assert!(worst.iter().all(|&error| error <= DIFFERENCES), "{worst:?}");
    }
}
