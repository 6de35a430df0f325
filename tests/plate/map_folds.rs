//! Maps of any lattice, folded ones too: every pixel comes from somewhere that goes there, and what overlaps is told.

use super::map::{BASES, random};
use super::support::{channel, layer, plate, warped};
use glam::DVec2;
use pinwarp::image::{Plate, Storage};
use pinwarp::lattice::{Basis, Grid, ScreenLattice};
use pinwarp::plate::{Coverage, Field, Matte, WarpMap, WarpSettings};
use pinwarp::space::{FrameSize, ImagePoint, PixelRect};

const FRAME: FrameSize = FrameSize { width: 160, height: 90, pixel_aspect: 1.0 };
/// Reaches out of the frame on all sides.
const WINDOW: PixelRect = PixelRect { x: -23, y: -11, width: 201, height: 117 };

/// Every pixel and where it came from, and how far from the pixel that place goes.
fn misses(field: &Field, map: &WarpMap) -> Vec<f64> {
    let width = map.window.width as usize;
    let miss = |index: usize| {
        let (x, y) = (map.window.x + (index % width) as i32, map.window.y + (index / width) as i32);
        let Some(source) = map.source(x, y) else { return f64::INFINITY };
        let there = field.carry(map.frame.screen_from_image(ImagePoint(DVec2::from(source))));
        (map.frame.image_from_screen(there).0 - DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).length()
    };
    (0..map.window.area()).map(miss).collect()
}

/// Whether the field turns over where a pixel came from.
fn is_turned_over(field: &Field, map: &WarpMap, index: u32) -> bool {
    let (x, y) = (map.window.x + (index % map.window.width) as i32, map.window.y + (index / map.window.width) as i32);
    let source = map.source(x, y).expect("it comes from somewhere");
    field.evaluate_with_gradient(map.frame.screen_from_image(ImagePoint(DVec2::from(source)))).1.determinant() < -1e-3
}

#[test]
fn every_pixel_comes_from_somewhere_that_goes_there() {
    for seed in 0..4 {
        // From a gentle bend to a crumpled sheet; cells that crumple crease everywhere.
        for basis in
            BASES.into_iter().filter(|basis| seed < 3 || *basis == Basis::Bernstein || *basis == Basis::Bspline)
        {
            let lattice = random(basis, 0.15 + 0.25 * f64::from(seed), seed);
            let frame = FrameSize { pixel_aspect: if seed % 2 == 0 { 1.0 } else { 1.42 }, ..FRAME };
            for field in [Field::of_layer(lattice.clone()), Field::of_picture(lattice.clone())] {
                let map = WarpMap::backward(&field, frame, WINDOW);
                let misses = misses(&field, &map);
                let mut is_folded = vec![false; misses.len()];
                map.folded_pixels.iter().for_each(|&index| is_folded[index as usize] = true);
                let plain = misses.iter().zip(&is_folded).filter(|(_, folded)| !**folded).map(|(miss, _)| *miss);
                let (worst_plain, worst) = (plain.fold(0.0, f64::max), misses.iter().copied().fold(0.0, f64::max));
                // Searches stop at the creases of cells; there the net's own answer stays.
                let has_creases = basis.is_local() && basis != Basis::Bspline;
                let limits = if has_creases { [1.0, 2.0] } else { [2e-2, 0.2] };
                assert!(worst_plain < limits[0] && worst < limits[1], "{basis:?} {seed}: {worst_plain} {worst}");
                let precise = misses.iter().filter(|miss| **miss < 1e-3).count();
                assert!(precise * 1000 > misses.len() * 995, "{basis:?} {seed}: {precise} of {}", misses.len());
                let turned = map.folded_pixels.iter().filter(|&&index| is_turned_over(&field, &map, index)).count();
                assert!(has_creases || turned * 100 <= map.folded_pixels.len() + 400, "{basis:?} {seed}: {turned}");
            }
        }
    }
}

#[test]
fn a_map_that_is_a_pixel_off_is_noticed() {
    let field = Field::of_picture(random(Basis::Bspline, 0.2, 1));
    let mut map = WarpMap::backward(&field, FRAME, WINDOW);
    map.offsets.iter_mut().for_each(|offset| offset[0] += 1.0);
    let misses = misses(&field, &map);
    assert!(misses.iter().all(|miss| *miss > 0.1));
}

/// A lattice that is pulled over itself.
fn pulled_over_lattice() -> ScreenLattice {
    let mut lattice = random(Basis::Bspline, 0.0, 0);
    let by = 2.6 * lattice.grid.spacing(0);
    for handle in lattice.handles.iter_mut().filter(|handle| handle[0] < 0.9 && (0.3..0.7).contains(&handle[1])) {
        handle[0] += by;
    }
    lattice
}

fn pulled_over() -> Field {
    Field::of_layer(pulled_over_lattice())
}

/// A lattice that carries its left part to the right and its right part to the left, by half the height of the frame; between them it
/// turns over.
fn crossed() -> ScreenLattice {
    let mut lattice =
        Grid { dims: [20, 4], basis: Basis::Bspline, lo: [0.0; 2], hi: [FRAME.aspect(), 1.0], angle: 0.0 }.at_rest();
    for handle in &mut lattice.handles {
        let across = (handle[0] / FRAME.aspect() - 0.4) / 0.2;
        handle[0] += 0.55 * (1.0 - 2.0 * across.clamp(0.0, 1.0));
    }
    lattice
}

/// A picture and its coverage.
fn picture(covers: impl Fn(u32, u32) -> bool) -> (Plate, Coverage) {
    let value = |x: u32, y: u32| f32::from(u8::from(covers(x, y)));
    let channels = ["R", "A"].map(|name| channel(name, Storage::Half, FRAME.window(), value));
    let samples = channels[1].samples.clone();
    (plate(FRAME.window(), FRAME.window(), channels.into()), Coverage { frame: FRAME, window: FRAME.window(), samples })
}

/// The pixels that are told as folded: by a warped plate, by the map back and by the map there.
fn told_of((plate, coverage): &(Plate, Coverage), field: &Field) -> [usize; 3] {
    let layers = vec![layer("all", field.clone(), Some(Matte::Alpha))];
    let (parts, place) = ([(field.clone(), coverage.clone())], FRAME.whole());
    [
        warped(plate, layers, &WarpSettings::default()).1.folded_pixels,
        WarpMap::backward_of_shares(&parts, coverage, place).folded_pixels.len(),
        WarpMap::forward_of_parts(&parts, place).folded_pixels.len(),
    ]
}

/// Legs that cross are on one branch, for they share no handles. A plain lattice holds the ground between them, too.
#[test]
fn parts_of_a_branch_that_pass_in_front_of_each_other_are_no_fold() {
    let legs = picture(|x, _| (20..42).contains(&x) || (118..140).contains(&x));
    assert_eq!(told_of(&legs, &Field::of_branch(crossed())), [0; 3]);
    let [of_plate, ..] = told_of(&legs, &Field::of_layer(crossed()));
    assert!(of_plate > 1000, "the legs lie over each other: {of_plate} pixels");
}

#[test]
fn folds_of_a_branch_are_told() {
    let sheet = picture(|_, _| true);
    let wanted = WarpMap::backward(&pulled_over(), FRAME, FRAME.window()).folded_pixels.len();
    let [of_plate, back, there] = told_of(&sheet, &Field::of_branch(pulled_over_lattice()));
    let is_right = [of_plate, back].iter().all(|told| (wanted * 9 / 10..=wanted).contains(told));
    assert!(wanted > 200 && is_right, "{of_plate} and {back} of {wanted}");
    assert!(there > wanted, "what is turned over, what lies over it and what lies under it: {there}");
    // Only what is turned over in the picture itself counts.
    let half = picture(|_, y| y < 45);
    let [of_plate, back, _] = told_of(&half, &Field::of_branch(pulled_over_lattice()));
    assert!([of_plate, back].iter().all(|&told| (wanted / 4..wanted * 3 / 4).contains(&told)), "{of_plate}, {back}");
}

#[test]
fn folds_are_reported_where_turned_over_parts_land() {
    let field = pulled_over();
    let map = WarpMap::backward(&field, FRAME, WINDOW);
    let mut is_folded = vec![false; WINDOW.area()];
    map.folded_pixels.iter().for_each(|&index| is_folded[index as usize] = true);
    let mut landed = vec![false; WINDOW.area()];
    for k in 0..(1600 * 900) {
        let point = ImagePoint(DVec2::new(0.1 * f64::from(k % 1600), 0.1 * f64::from(k / 1600)));
        let (image, gradient) = field.evaluate_with_gradient(FRAME.screen_from_image(point));
        let at = FRAME.image_from_screen(image).0.floor() - DVec2::new(f64::from(WINDOW.x), f64::from(WINDOW.y));
        if gradient.determinant() < 0.0 && at.min_element() >= 0.0 && at.x < 201.0 && at.y < 117.0 {
            landed[at.y as usize * 201 + at.x as usize] = true;
        }
    }
    let (both, either) = is_folded
        .iter()
        .zip(&landed)
        .fold((0, 0), |(both, either), (a, b)| (both + usize::from(*a && *b), either + usize::from(*a || *b)));
    // Pixels on the crease are partly covered.
    assert!(both > 200 && both * 10 > either * 8, "{both} of {either}");
}

#[test]
fn hidden_preimages_are_reported_where_the_picture_overlaps_itself() {
    let field = pulled_over();
    let sheets = WarpMap::backward_preimages(&field, FRAME, WINDOW);
    let front = WarpMap::backward(&field, FRAME, WINDOW);
    assert!(sheets.len() >= 2);
    assert_eq!(sheets[0], front);
    let told = sheets[1].folded_pixels.iter().all(|&index| sheets[1].offsets[index as usize][0].is_finite());
    assert!(told && sheets[1].folded_pixels.len() > 200);
    let behind = sheets[1].offsets.iter().enumerate().filter(|(_, offset)| offset[0].is_finite());
    let behind: Vec<u32> = behind.map(|(index, _)| index as u32).collect();
    let near = behind.iter().filter(|index| front.folded_pixels.binary_search(index).is_ok()).count();
    assert!(behind.len() > 200 && near * 10 > behind.len() * 8, "{near} of {}", behind.len());
    for &index in &behind {
        let length = |map: &WarpMap| map.offsets[index as usize].iter().map(|x| x * x).sum::<f32>();
        assert!(length(&front) >= length(&sheets[1]), "what moved further lies in front");
    }
}

#[test]
fn a_warped_plate_reports_where_it_overlaps_itself() {
    let field = pulled_over();
    let wanted = WarpMap::backward(&field, FRAME, FRAME.window()).folded_pixels.len();
    let whole = |_: u32, _: u32| 1.0;
    let far = |x: u32, _: u32| if x < 10 { 1.0 } else { 0.0 };
    let channels = [("R", &whole as &dyn Fn(u32, u32) -> f32), ("near.A", &whole), ("far.A", &far)];
    let channels = channels.map(|(name, value)| channel(name, Storage::Half, FRAME.window(), value));
    let plate = plate(FRAME.window(), FRAME.window(), channels.into());
    let folded = |field: &Field, matte: Option<&str>| {
        let matte = matte.map(|name| Matte::Channel(name.into()));
        warped(&plate, vec![layer("all", field.clone(), matte)], &WarpSettings::default()).1.folded_pixels
    };
    assert!(wanted > 200);
    assert_eq!(folded(&field, None), wanted);
    assert_eq!(folded(&field, Some("near.A")), wanted, "both sheets, but each pixel once");
    assert_eq!(folded(&field, Some("far.A")), 0, "the layer has nothing there");
    assert_eq!(folded(&Field::of_layer(random(Basis::Bspline, 0.2, 1)), None), 0);
}

/// Outside its lattice a layer is moved less and less, and by a rotation of more than a right angle turned over. Nothing of the layer is
/// there.
#[test]
fn a_rotated_layer_does_not_fold() {
    let mut lattice =
        Grid { dims: [6, 6], basis: Basis::Bspline, lo: [0.6, 0.2], hi: [1.2, 0.8], angle: 0.0 }.at_rest();
    let rotated = |handle: &[f64; 2]| {
        let center = DVec2::new(0.9, 0.5);
        (center + DVec2::from_angle(2.1).rotate(DVec2::from(*handle) - center)).to_array()
    };
    lattice.handles.iter_mut().for_each(|handle| *handle = rotated(handle));
    let field = Field::of_layer(lattice);
    assert!(WarpMap::backward(&field, FRAME, FRAME.window()).folded_pixels.len() > 200, "the field folds");
    let disc = |x: u32, y: u32| f32::from(u8::from((f64::from(x) - 81.0).hypot(f64::from(y) - 45.0) < 24.0));
    let channels = [("R", &disc as &dyn Fn(u32, u32) -> f32), ("A", &disc)];
    let channels = channels.map(|(name, value)| channel(name, Storage::Half, FRAME.window(), value));
    let plate = plate(FRAME.window(), FRAME.window(), channels.into());
    let folded = |field: Field| {
        let layers = vec![layer("all", field, Some(Matte::Alpha))];
        warped(&plate, layers, &WarpSettings::default()).1.folded_pixels
    };
    assert_eq!(folded(field), 0);
    assert!(folded(pulled_over()) > 50, "what is seen twice is reported");
}

#[test]
fn steps_across_the_edge_of_a_sheet_do_not_count() {
    let map = WarpMap::backward(&pulled_over(), FRAME, WINDOW);
    let torn = (0..WINDOW.area() - 1)
        .filter(|&index| (map.offsets[index + 1][0] - map.offsets[index][0]).abs() > 10.0 && index % 201 != 200);
    let mut count = 0;
    for index in torn {
        let slopes = map.jacobian(index);
        assert!(slopes[0][0].abs() < 9.0, "{index}: {slopes:?}");
        count += 1;
    }
    assert!(count > 5);
}
