//! A rectangle of pixels of a map.

/// A rectangle of the map.
#[derive(Clone, Copy)]
pub(super) struct Area {
    pub(super) column: usize,
    pub(super) row: usize,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Area {
    /// Splits the area in two across its longer side.
    pub(super) fn halves(self) -> [Self; 2] {
        if self.width >= self.height {
            let left = self.width / 2;
            let right = Self { column: self.column + left, width: self.width - left, ..self };
            [Self { width: left, ..self }, right]
        } else {
            let upper = self.height / 2;
            let lower = Self { row: self.row + upper, height: self.height - upper, ..self };
            [Self { height: upper, ..self }, lower]
        }
    }

    /// Returns its row range in the map.
    pub(super) fn rows(self) -> std::ops::Range<usize> {
        self.row..self.row + self.height
    }
}
