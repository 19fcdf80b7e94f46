use crate::lanes::{Lanes, ROW, Row};
use crate::narrow_phase::SLOTS;

/// The corners of up to eight polygons, side by side, each of at most [`SLOTS`] corners.
pub(super) struct Corners {
    /// Counter-clockwise; after the last corner the first, as often as there is room.
    rows: [[Row; 2]; SLOTS + 1],
    /// How many corners each polygon has.
    counts: [usize; ROW],
    /// How many polygons there are.
    pub len: usize,
}

impl Corners {
    pub const NONE: Self = Self {
        rows: [[[0.0; ROW]; 2]; SLOTS + 1],
        counts: [0; ROW],
        len: 0,
    };

    /// Sets a corner of the polygon in a lane.
    pub fn set(&mut self, lane: usize, corner: usize, [y1, y2]: [f64; 2]) {
        let row = &mut self.rows[corner % SLOTS];
        (row[0][lane], row[1][lane]) = (y1, y2);
    }

    /// Closes the polygon in a lane, which has this many corners.
    pub fn close(&mut self, lane: usize, count: usize) {
        let first = self.rows[0].map(|row| row[lane]);
        for row in &mut self.rows[count.min(SLOTS)..] {
            (row[0][lane], row[1][lane]) = (first[0], first[1]);
        }
        self.counts[lane] = count;
    }

    /// Makes polygons without an area of the lanes that are free.
    pub fn fill_up(&mut self) {
        for row in self.rows.iter_mut().flatten() {
            row[self.len..].fill(0.0);
        }
        self.counts[self.len..].fill(0);
    }

    /// How many corners the polygon in a lane has.
    pub fn count(&self, lane: usize) -> usize {
        self.counts[lane]
    }

    /// The most corners of as many polygons as there are lanes.
    #[inline(always)]
    pub fn most<L: Lanes>(&self, first: usize) -> usize {
        let mut most = 0;
        for lane in first..first + L::COUNT {
            most = self.counts[lane].max(most);
        }
        most
    }

    /// A corner of each polygon from `first` on.
    #[inline(always)]
    pub fn at<L: Lanes>(&self, lanes: L, corner: usize, first: usize) -> [L::Numbers; 2] {
        let [y1, y2] = &self.rows[corner.min(SLOTS)];
        [lanes.load(y1, first), lanes.load(y2, first)]
    }
}
