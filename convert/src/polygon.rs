//! Polygons cut into triangles by clipping ears.
//!
//! A polygon is projected along the axis that its Newell normal (M. E. Newell; Sutherland, Sproull, Schumacker, "A
//! Characterization of Ten Hidden-Surface Algorithms", 1974) is nearest to, so coordinates stay the exact `f32` of the
//! file and the signs of areas in `f64` are right. An ear is a convex corner whose triangle holds no other corner. A grid
//! over the reflex corners, rebuilt whenever half the corners are gone, keeps this near linear; a polygon that crosses
//! itself may have no ear, and then a convex corner is cut all the same. The work is bounded whatever the shape.

use glam::{DVec2, DVec3};

/// Cuts polygons; one value serves many, so that nothing is allocated for each.
#[derive(Default)]
pub(crate) struct Triangulator {
    points: Vec<DVec2>,
    previous: Vec<u32>,
    next: Vec<u32>,
    alive: Vec<bool>,
    grid: Grid,
}

impl Triangulator {
    /// Appends the `points.len() − 2` triangles of a polygon, as positions in `points`, wound as it is.
    ///
    /// False if the polygon crosses itself, is degenerate, or is too intricate for the bounded search: its triangles
    /// then cover all corners but may overlap.
    pub(crate) fn triangulate(&mut self, points: &[[f32; 3]], triangles: &mut Vec<[u32; 3]>) -> bool {
        let count = points.len() as u32;
        if count <= 3 {
            triangles.extend((count == 3).then_some([0, 1, 2]));
            return true;
        }
        let Some(twice_area) = self.project(points) else {
            fan(count, triangles);
            return false;
        };
        if self.strictly_convex() {
            fan(count, triangles);
            return true;
        }
        let first = triangles.len();
        let clean = self.clip(triangles);
        let covered: f64 = triangles[first..].iter().map(|&[a, b, c]| self.area(a, b, c).abs()).sum();
        clean && covered <= twice_area * (1.0 + 1e-9)
    }

    /// Fills `points` so that the polygon runs counter-clockwise; twice its area, or `None` if it has none.
    fn project(&mut self, points: &[[f32; 3]]) -> Option<f64> {
        let at = |index: usize| DVec3::from(points[index % points.len()].map(f64::from));
        let origin = at(0);
        let mut normal = DVec3::ZERO;
        let mut extent = 0.0_f64;
        for index in 0..points.len() {
            let (a, b) = (at(index) - origin, at(index + 1) - origin);
            normal += a.cross(b);
            extent = extent.max(a.length_squared());
        }
        let (axis, along) = (0..3).map(|axis| (axis, normal[axis])).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        if along.abs().is_nan() || along.abs() <= 1e-14 * extent {
            return None;
        }
        let (mut x, mut y) = ((axis + 1) % 3, (axis + 2) % 3);
        if along < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        self.points.clear();
        self.points.extend(points.iter().map(|point| DVec2::new(f64::from(point[x]), f64::from(point[y]))));
        Some(along.abs())
    }

    /// Twice the signed area of a triangle.
    fn area(&self, a: u32, b: u32, c: u32) -> f64 {
        let [a, b, c] = [a, b, c].map(|index| self.points[index as usize]);
        (b - a).perp_dot(c - b)
    }

    /// All corners turn left, and the polygon goes round once.
    fn strictly_convex(&self) -> bool {
        let count = self.points.len();
        let edge = |index: usize| self.points[(index + 1) % count] - self.points[index % count];
        let mut turns_back = 0;
        let mut last = 0.0_f64;
        for index in 0..count {
            if edge(index).perp_dot(edge(index + 1)) <= 0.0 {
                return false;
            }
            let x = edge(index).x;
            if x != 0.0 {
                turns_back += usize::from(last != 0.0 && x.signum() != last.signum());
                last = x;
            }
        }
        // The change between the last edge and the first may be one more.
        turns_back <= 2
    }

    fn clip(&mut self, triangles: &mut Vec<[u32; 3]>) -> bool {
        let count = self.points.len() as u32;
        self.previous.clear();
        self.previous.extend((0..count).map(|at| (at + count - 1) % count));
        self.next.clear();
        self.next.extend((0..count).map(|at| (at + 1) % count));
        self.alive.clear();
        self.alive.resize(count as usize, true);

        let mut left = count;
        let mut rebuild_at = count;
        let mut budget = (1 << 20) + 512 * u64::from(count);
        let mut clean = true;
        // A corner can become an ear when a neighbour goes, or rarely when one goes that its triangle held: so the
        // neighbours come next, and all are looked at again when there are none.
        let mut round: Vec<u32> = (0..count).collect();
        let mut next_round: Vec<u32> = Vec::new();
        let mut ears_since_all = 1;
        // A corner that is still there; the search for a corner to force goes on from it.
        let mut around = 0;
        while left > 3 {
            // Leaving out the corner after an ear gives better shapes than a fan.
            let mut skipped = None;
            for at in round.drain(..) {
                if left == 3 || !self.alive[at as usize] {
                    continue;
                }
                if left <= rebuild_at {
                    rebuild_at = left / 2;
                    let reflex = (0..count).filter(|at| self.alive[*at as usize] && !self.convex(*at));
                    self.grid.build(&self.points, reflex.collect());
                }
                if skipped == Some(at) {
                    next_round.push(at);
                } else if self.ear(at, &mut budget) {
                    let [before, _, after] = self.cut(at, triangles);
                    next_round.extend([before, after]);
                    skipped = Some(after);
                    left -= 1;
                    ears_since_all += 1;
                }
            }
            std::mem::swap(&mut round, &mut next_round);
            round.dedup();
            while !self.alive[around as usize] {
                around = self.next[around as usize];
            }
            if round.is_empty() && left > 3 {
                if ears_since_all > 0 {
                    round.extend((0..count).filter(|at| self.alive[*at as usize]));
                } else {
                    // The polygon crosses itself: any convex corner must do, and without one any corner.
                    clean = false;
                    let end = around;
                    while !self.convex(around) && self.next[around as usize] != end && budget > 0 {
                        budget -= 1;
                        around = self.next[around as usize];
                    }
                    let [before, _, after] = self.cut(around, triangles);
                    round.extend([before, after]);
                    left -= 1;
                }
                ears_since_all = 0;
            }
        }
        self.cut(around, triangles);
        clean && budget > 0
    }

    /// Cuts a corner off; gives the triangle.
    fn cut(&mut self, at: u32, triangles: &mut Vec<[u32; 3]>) -> [u32; 3] {
        let (before, after) = (self.previous[at as usize], self.next[at as usize]);
        triangles.push([before, at, after]);
        self.alive[at as usize] = false;
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
        [before, at, after]
    }

    fn convex(&self, at: u32) -> bool {
        self.area(self.previous[at as usize], at, self.next[at as usize]) > 0.0
    }

    fn ear(&self, at: u32, budget: &mut u64) -> bool {
        *budget = budget.saturating_sub(1);
        if *budget == 0 {
            return true;
        }
        let (before, after) = (self.previous[at as usize], self.next[at as usize]);
        if self.area(before, at, after) <= 0.0 || !self.in_cone(before, after) || !self.in_cone(after, before) {
            return false;
        }
        let corners = [before, at, after];
        let places = corners.map(|index| self.points[index as usize]);
        self.grid.all_near(places, budget, |other| {
            let point = self.points[other as usize];
            let apart = !self.alive[other as usize] || places.contains(&point);
            let side = |a: usize, b: usize| (places[b] - places[a]).perp_dot(point - places[b]) >= 0.0;
            apart || !(side(0, 1) && side(1, 2) && side(2, 0))
        })
    }

    /// Whether the line from a corner to another one starts on the inside.
    fn in_cone(&self, from: u32, to: u32) -> bool {
        let (before, after) = (self.previous[from as usize], self.next[from as usize]);
        if self.area(before, from, after) > 0.0 {
            self.area(from, to, before) >= 0.0 && self.area(to, from, after) >= 0.0
        } else {
            !(self.area(from, to, after) > 0.0 && self.area(to, from, before) > 0.0)
        }
    }
}

fn fan(count: u32, triangles: &mut Vec<[u32; 3]>) {
    triangles.extend((1..count - 1).map(|at| [0, at, at + 1]));
}

/// Corners sorted into square cells.
#[derive(Default)]
struct Grid {
    origin: DVec2,
    /// Cells a unit of length.
    density: DVec2,
    across: usize,
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl Grid {
    fn build(&mut self, points: &[DVec2], corners: Vec<u32>) {
        let places = || corners.iter().map(|corner| points[*corner as usize]);
        let low = places().fold(DVec2::INFINITY, DVec2::min);
        let high = places().fold(DVec2::NEG_INFINITY, DVec2::max);
        self.across = (corners.len() as f64).sqrt().ceil().clamp(1.0, 2048.0) as usize;
        self.origin = low;
        self.density =
            (self.across as f64 / (high - low).max(DVec2::splat(f64::MIN_POSITIVE))).min(DVec2::splat(1e300));
        self.starts.clear();
        self.starts.resize(self.across * self.across + 1, 0);
        let cell = |point: DVec2| self.row(point.y) * self.across + self.column(point.x);
        let cells: Vec<usize> = places().map(cell).collect();
        cells.iter().for_each(|cell| self.starts[cell + 1] += 1);
        for cell in 1..self.starts.len() {
            self.starts[cell] += self.starts[cell - 1];
        }
        let mut next = self.starts.clone();
        self.corners.clear();
        self.corners.resize(corners.len(), 0);
        for (corner, cell) in corners.into_iter().zip(cells) {
            self.corners[next[cell] as usize] = corner;
            next[cell] += 1;
        }
    }

    fn column(&self, x: f64) -> usize {
        (((x - self.origin.x) * self.density.x).max(0.0) as usize).min(self.across - 1)
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.origin.y) * self.density.y).max(0.0) as usize).min(self.across - 1)
    }

    /// Whether `test` holds for all corners in the cells that a triangle's box touches. Once the budget is spent,
    /// nothing is looked at.
    fn all_near(&self, triangle: [DVec2; 3], budget: &mut u64, mut test: impl FnMut(u32) -> bool) -> bool {
        if self.corners.is_empty() {
            return true;
        }
        let low = triangle[0].min(triangle[1]).min(triangle[2]);
        let high = triangle[0].max(triangle[1]).max(triangle[2]);
        for row in self.row(low.y)..=self.row(high.y) {
            let first = self.starts[row * self.across + self.column(low.x)];
            let end = self.starts[row * self.across + self.column(high.x) + 1];
            for corner in &self.corners[first as usize..end as usize] {
                *budget = budget.saturating_sub(1);
                if *budget == 0 {
                    return true;
                }
                if !test(*corner) {
                    return false;
                }
            }
            *budget = budget.saturating_sub(1);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(points: &[[f32; 3]]) -> (Vec<[u32; 3]>, bool) {
        let mut triangles = Vec::new();
        let clean = Triangulator::default().triangulate(points, &mut triangles);
        assert_eq!(triangles.len(), points.len() - 2);
        (triangles, clean)
    }

    /// Each triangle's area as a vector; all have the polygon's direction if none is turned over.
    fn areas(points: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<DVec3> {
        let at = |index: u32| DVec3::from(points[index as usize].map(f64::from));
        triangles.iter().map(|&[a, b, c]| 0.5 * (at(b) - at(a)).cross(at(c) - at(a))).collect()
    }

    fn assert_covers(points: &[[f32; 3]]) {
        let (triangles, clean) = cut(points);
        assert!(clean);
        let at = |index: usize| DVec3::from(points[index % points.len()].map(f64::from));
        let whole: DVec3 = (0..points.len()).map(|index| 0.5 * at(index).cross(at(index + 1))).sum();
        let parts = areas(points, &triangles);
        let sum: f64 = parts.iter().map(|part| part.length()).sum();
        assert!((sum - whole.length()).abs() < 1e-6 * sum, "{sum} is not {}", whole.length());
        assert!(parts.iter().all(|part| part.dot(whole) >= 0.0), "a triangle is turned over");
        // Each edge of the polygon is an edge of exactly one triangle, in its own direction.
        for from in 0..points.len() as u32 {
            let edge = [from, (from + 1) % points.len() as u32];
            let owners = triangles.iter().filter(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]].contains(&edge)).count();
            assert_eq!(owners, 1, "edge {edge:?}");
        }
    }

    /// In the plane spanned by two slanted axes.
    fn slanted(points: &[[f32; 2]]) -> Vec<[f32; 3]> {
        points.iter().map(|[x, y]| [x * 0.6 + 0.25 * y, 0.8 * x - 0.5 * y, 0.5 * y + 3.0]).collect()
    }

    #[test]
    fn a_convex_polygon_is_a_fan() {
        let hexagon: Vec<[f32; 2]> = (0..6).map(|at| (at as f32).sin_cos()).map(|(s, c)| [c, s]).collect();
        let (triangles, clean) = cut(&slanted(&hexagon));
        assert!(clean);
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
    }

    #[test]
    fn a_quad_with_a_reflex_corner_is_cut_through_it() {
        let dart = [[0., 0., 0.], [2., 1., 0.], [0., 2., 0.], [0.5, 1., 0.]];
        for turn in 0..4 {
            let mut points = dart;
            points.rotate_left(turn);
            assert_covers(&points);
            let mut backwards = points;
            backwards.reverse();
            assert_covers(&backwards);
        }
    }

    #[test]
    fn concave_polygons_keep_their_area() {
        for points in [
            // L, comb, arrow with collinear corners.
            vec![[0., 0.], [3., 0.], [3., 1.], [1., 1.], [1., 3.], [0., 3.]],
            vec![
                [0., 0.],
                [7., 0.],
                [7., 3.],
                [6., 3.],
                [6., 1.],
                [5., 1.],
                [5., 3.],
                [4., 3.],
                [4., 1.],
                [3., 1.],
                [3., 3.],
                [2., 3.],
                [2., 1.],
                [1., 1.],
                [1., 3.],
                [0., 3.],
            ],
            vec![[0., 0.], [1., 0.], [2., 0.], [4., 0.], [4., 1.], [6., -1.], [4., -3.], [4., -2.], [0., -2.]],
        ] {
            assert_covers(&slanted(&points));
        }
    }

    #[test]
    fn stars_and_spirals() {
        for points in [5_usize, 12, 501, 20_000] {
            let star: Vec<[f32; 2]> = (0..2 * points)
                .map(|at| {
                    let (sin, cos) = (std::f64::consts::PI * at as f64 / points as f64).sin_cos();
                    let radius = if at % 2 == 0 { 2.0 } else { 1.0 };
                    [(radius * cos) as f32, (radius * sin) as f32]
                })
                .collect();
            if points < 1000 {
                assert_covers(&slanted(&star));
            } else {
                assert!(cut(&slanted(&star)).1);
            }
        }
        for steps in [400_u32, 20_000] {
            let arm = |at: u32, width: f32| {
                let turn = 20.0 * std::f32::consts::TAU * at as f32 / steps as f32;
                let radius = 1.0 + turn / std::f32::consts::TAU + width;
                [radius * turn.cos(), radius * turn.sin()]
            };
            let spiral: Vec<[f32; 2]> =
                (0..steps).map(|at| arm(at, 0.4)).chain((0..steps).rev().map(|at| arm(at, 0.0))).collect();
            if steps == 400 {
                assert_covers(&slanted(&spiral));
            } else {
                assert!(cut(&slanted(&spiral)).1);
            }
        }
    }

    #[test]
    fn a_hole_on_a_bridge() {
        let frame =
            [[0., 0.], [4., 0.], [4., 4.], [0., 4.], [0., 0.], [1., 1.], [1., 3.], [3., 3.], [3., 1.], [1., 1.]];
        let points = slanted(&frame);
        let (triangles, clean) = cut(&points);
        assert!(clean);
        let area: f64 = areas(&points, &triangles).iter().map(|area| area.length()).sum();
        let unit = areas(&slanted(&[[0., 0.], [1., 0.], [0., 1.]]), &[[0, 1, 2]])[0].length();
        assert!((area / unit - 24.0).abs() < 1e-5, "{}", area / unit);
    }

    #[test]
    fn polygons_that_make_no_sense_are_cut_all_the_same() {
        let crossing = [[0., 0., 0.], [1., 1., 0.], [1., 0., 0.], [0., 1., 0.]];
        let line = [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [3., 0., 0.]];
        let point = [[1., 2., 3.]; 5];
        let star: Vec<[f32; 3]> = (0..5).map(|at| (at as f32 * 2.513).sin_cos()).map(|(s, c)| [s, c, 0.]).collect();
        for points in [&crossing[..], &line, &point, &star] {
            assert!(!cut(points).1, "{points:?}");
        }
        let mut number = 1_u32;
        let mut random = || {
            number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (number >> 8) as f32 / 16_777_216.0
        };
        let tangle: Vec<[f32; 3]> = (0..500_000).map(|_| [random(), random(), random()]).collect();
        assert!(!cut(&tangle).1);
    }
}
