use super::sums::OverOctets;
use super::{ContactBody, Culling, Partner, Search};
use crate::geometry::{AffineField, ConvexPolygon, PolygonMoments};
use crate::narrow_phase::{
    Cut, ELASTIC_COINCIDENCE, EquilibriumPlane, RelativePair, Weights, scales,
};
use crate::scalar::{Scalar, carries_derivatives, real_part};
use crate::search::Found;
use crate::spatial::Pose;

/// No more than this fraction of the load may be taken for zero.
const LITTLE: f64 = 1e-6;

/// Where more would be, the tolerance is taken this many octaves narrower.
const NARROWER: usize = 3;

/// A pair of bodies from which contact polygons are made in `T`, in A's frame.
pub(super) struct PolygonSource<'a, T> {
    pub pair: RelativePair<'a>,
    pub modulus_a: T,
    /// What extents are multiplied by in the two fields that are equal on the plane (see [`RelativePair::scales`]).
    scales: [T; 2],
    pub pose_ab: Pose<T>,
}

/// Cuts, and the source that makes polygons of them, by what counted as coincident.
pub(super) struct CutSurface<'a, T> {
    pub source: PolygonSource<'a, T>,
    pub found: Found,
}

/// The surface that derivatives are made from and, if it may be another, that for values.
pub(super) type Surfaces<'a, T> = (CutSurface<'a, T>, Option<CutSurface<'a, T>>);

/// The contact polygon of a cut in `T`, in A's frame.
pub(super) struct CutPolygon<T> {
    pub polygon: ConvexPolygon<T>,
    pub plane: EquilibriumPlane<T>,
    /// How much of it counts.
    pub weights: Weights,
    /// All of it, whatever counts.
    pub moments: PolygonMoments<T>,
    pub pressure_a: AffineField<T>,
    /// The pressure on the polygon (Pa): both bodies' fields are the same there, and this is the one
    /// of the smaller gradient, which is rounded less; A's, if B is rigid.
    pub pressure: AffineField<T>,
}

impl<'a, T: Scalar> PolygonSource<'a, T> {
    pub fn of(a: &ContactBody<'a, T>, b: &Partner<'a, T>) -> Self {
        let pose_ab = a.pose().inverse() * *b.pose();
        Self {
            pair: RelativePair::of(a, b, &pose_ab),
            modulus_a: a.modulus(),
            scales: scales(a, b),
            pose_ab,
        }
    }

    /// The surface that values are made from.
    pub fn for_values(&self, search: Search) -> CutSurface<'a, T> {
        self.values_from(self.within(0, search))
    }

    /// As [`Self::for_values`], to be summed: of a large surface, octets are summed as soon as they are found, and are not in it.
    /// Where whole polygons lie on faces as well, it is searched once more: that is rarer than that memory would be short.
    pub fn for_sum_of_values<S: OverOctets>(&self, search: Search) -> (CutSurface<'a, T>, S) {
        let (plain, sum) = self.summed_within(0, search);
        match sum {
            Some(_) if plain.has_polygons_on_faces() => (self.for_values(search), S::empty()),
            Some(sum) => (plain, sum),
            None => (self.values_from(plain), S::empty()),
        }
    }

    /// The surface that derivatives are made from. That for values as well, if it may be another.
    pub fn for_derivatives(&self, octaves: u32, search: Search) -> Surfaces<'a, T> {
        let surface = self.within(octaves.cast_signed(), search);
        self.derivatives_from(surface, octaves, search)
    }

    /// As [`Self::for_derivatives`], to be summed: see [`Self::for_sum_of_values`].
    pub fn for_sum_of_derivatives<S: OverOctets>(
        &self,
        octaves: u32,
        search: Search,
    ) -> (Surfaces<'a, T>, S) {
        let (surface, sum) = self.summed_within(octaves.cast_signed(), search);
        match sum {
            Some(_) if surface.found.noted_closeness().is_within(octaves) => {
                (self.for_derivatives(octaves, search), S::empty())
            }
            Some(sum) => ((surface, None), sum),
            None => (self.derivatives_from(surface, octaves, search), S::empty()),
        }
    }

    fn values_from(&self, plain: CutSurface<'a, T>) -> CutSurface<'a, T> {
        if !plain.has_polygons_on_faces() {
            return plain;
        }
        // All of it, whichever search: slivers between such planes hang together by less than is told from zero.
        let everywhere = Search::Culling(Culling::default());
        let surface = self.within(ELASTIC_COINCIDENCE.cast_signed(), everywhere);
        self.settled(surface, ELASTIC_COINCIDENCE, everywhere, || plain)
            .0
    }

    fn derivatives_from(
        &self,
        surface: CutSurface<'a, T>,
        octaves: u32,
        search: Search,
    ) -> Surfaces<'a, T> {
        self.settled(surface, octaves, search, || self.for_values(search))
    }

    /// The surface where faces within 2^octaves margins of each other count as coincident. The octaves are others where that
    /// many would merge distinct corners (see [`Closeness::split`]), and fewer where they would take the load for zero:
    /// bodies that are pressed in by less do not just touch. For this they are narrowed down to the margin, which values are
    /// made with. Otherwise the load may change: where it jumps as faces pass
    /// each other, the derivatives belong to neither side.
    ///
    /// If there are such faces, gives the finer surface as well. They are looked for in cuts that do not count, too: where corners
    /// are taken to be on the plane, nothing may be left of a polygon.
    ///
    /// [`Closeness::split`]: crate::geometry::Closeness::split
    fn settled(
        &self,
        surface: CutSurface<'a, T>,
        octaves: u32,
        search: Search,
        finer: impl FnOnce() -> CutSurface<'a, T>,
    ) -> Surfaces<'a, T> {
        if !surface.found.noted_closeness().is_within(octaves) {
            return (surface, None);
        }
        let finer = finer();
        let closeness = [&surface, &finer].map(|either| either.found.closeness());
        let Some(closeness) = closeness.into_iter().find(|near| near.is_within(octaves)) else {
            return (surface, Some(finer));
        };
        let load = finer.load();
        let leaves_load = |octaves: &i32| finer.load_at_zero(*octaves) <= LITTLE * load;
        let split = closeness.split(octaves);
        let mut narrower = (1..=split).rev().step_by(NARROWER);
        let split = narrower.find(leaves_load).unwrap_or(split.min(0));
        if split == octaves.cast_signed() {
            return (surface, Some(finer));
        }
        (self.within(split, search), Some(finer))
    }

    /// With coincidences to within 2^octaves margins.
    fn with_near_coincidences(&self, octaves: i32) -> Self {
        Self {
            pair: self.pair.with_near_coincidences(octaves),
            ..*self
        }
    }

    fn within(&self, octaves: i32, search: Search) -> CutSurface<'a, T> {
        let source = self.with_near_coincidences(octaves);
        CutSurface {
            found: source.pair.found(search),
            source,
        }
    }

    /// The same, and the sum over the octets that are not in it, if there are any.
    fn summed_within<S: OverOctets>(
        &self,
        octaves: i32,
        search: Search,
    ) -> (CutSurface<'a, T>, Option<S>) {
        if carries_derivatives::<T>() {
            return (self.within(octaves, search), None);
        }
        let (source, mut sum) = (self.with_near_coincidences(octaves), None);
        let found = source.pair.found_spilling(search, &mut |octets| {
            sum.get_or_insert_with(S::empty).merge(S::over(octets));
        });
        (CutSurface { source, found }, sum)
    }

    /// The polygon of a cut if it is part of the contact surface: it has an area, under pressure.
    pub fn pressed_polygon(&self, cut: &Cut) -> Option<CutPolygon<T>> {
        let may_press = cut.weights().still.area() > 0.0 && !cut.is_at_ends();
        may_press
            .then(|| self.polygon(cut))
            .filter(CutPolygon::has_area)
    }

    /// The polygon of a cut. For an `f64` it is there already; with derivatives it is made again, by the same cuts.
    pub fn polygon(&self, cut: &Cut) -> CutPolygon<T> {
        let tets = [self.pair.tet_a(cut.tets[0]), self.pair.tet_b(cut.tets[1])];
        let pressure_a = tets[0].extent.lifted().scaled(self.modulus_a);
        let (polygon, field_b) = if carries_derivatives::<T>() {
            let field_b = tets[1].extent.posed(&self.pose_ab).scaled(self.scales[1]);
            let fields = (self.scales[0], &field_b);
            let polygon = self.pair.polygon_in(cut, fields, &self.pose_ab);
            (polygon, field_b)
        } else {
            (cut.polygon.lifted(), cut.field_b.lifted())
        };
        let is_rigid = self.pair.shape_b.is_rigid();
        let plane = if is_rigid {
            EquilibriumPlane::of_rigid(&field_b)
        } else {
            EquilibriumPlane::between(&pressure_a, &field_b)
        };
        let [gradient_a, gradient_b] = [0, 1].map(|i| self.pair.scales[i] * tets[i].steepness);
        CutPolygon {
            weights: cut.weights(),
            moments: polygon.moments(&plane.normal),
            polygon,
            plane,
            pressure_a,
            pressure: if is_rigid || gradient_a <= gradient_b {
                pressure_a
            } else {
                field_b
            },
        }
    }

    /// Of A, and of B, which has 1 if it is rigid.
    pub fn moduli(&self) -> [T; 2] {
        [self.modulus_a, self.scales[1]]
    }

    /// What the rounding of a coordinate can make of the pressure on the polygon of a cut (Pa/m).
    pub fn sensitivity(&self, cut: &Cut) -> f64 {
        let [a, b] = [self.pair.tet_a(cut.tets[0]), self.pair.tet_b(cut.tets[1])];
        let of_a = real_part(self.modulus_a) * a.sensitivity;
        if self.pair.shape_b.is_rigid() {
            of_a
        } else {
            of_a.min(self.pair.scales[1] * b.sensitivity)
        }
    }
}

impl<T: Scalar> CutPolygon<T> {
    /// Whether it turns about its normal: else nothing but round-off is left of it.
    pub fn has_area(&self) -> bool {
        real_part(self.moments.area) > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactBody, ContactPair, Shape};
    use crate::mesh::shapes;
    use crate::narrow_phase::COINCIDENCE;
    use nalgebra::vector;

    /// Rounding of a depth of 1.5 margins, which is some 1e-13 of the height that the upper cube is placed at.
    const ROUNDING: f64 = 1e-2;

    /// How far apart (m) faces may be that count as coincident, for derivatives; the same for values; and how deep the bodies are
    /// pressed in: cubes, by so many margins.
    fn tolerances(octaves: u32, margins: f64) -> [f64; 3] {
        let cube = Shape::new(shapes::cuboid([1.0; 3]).unwrap());
        let body = |height: f64| {
            let place = Pose::from_translation(vector![0.1, 0.2, 1.0].scale(height));
            ContactBody::new(&cube, place, 1.0).unwrap()
        };
        let margin = |upper: ContactBody| ContactPair::new(upper, body(0.0)).source().pair.margin();
        let depth = margins * margin(body(1.0));
        let place = Pose::from_translation(vector![0.1, 0.2, 1.0 - depth]);
        let upper = ContactBody::new(&cube, place, 1.0).unwrap();
        let pair = ContactPair::new(upper, body(0.0));
        let source = pair.source();
        let (surface, _) = source.for_derivatives(octaves, pair.search());
        [surface.source.pair.margin(), source.pair.margin(), depth]
    }

    /// It is the pressure half as deep that is held against the tolerance, of which there is one every three octaves.
    #[test]
    fn faces_count_as_coincident_within_what_bodies_are_pressed_in_by_and_not_only_within_much_less()
     {
        for octaves in [ELASTIC_COINCIDENCE, COINCIDENCE] {
            for margins in [1.5, 3.0, 5.0, 10.0, 30.0, 1e2, 3e2, 1e3, 3e3, 1e4, 3e4, 1e6] {
                let [found, least, depth] = tolerances(octaves, margins);
                let most = least * f64::from(1 << octaves);
                assert!((least..=most).contains(&found), "{margins:e}");
                assert!(found <= depth.max(least), "{margins:e}");
                let sixteenth = depth / 16.0 * (1.0 - ROUNDING);
                assert!(found >= sixteenth.min(most), "{margins:e}");
            }
        }
    }
}
