//! Our filters beside those of OpenCV and OpenImageIO, on one warp.

use super::python;
use pinwarp::plate::{Filter, Planes, WarpMap, resampled};
use pinwarp::space::FrameSize;
use std::path::Path;

const FRAME: FrameSize = FrameSize::new(200, 150);

/// Compares away from the borders, where the programs differ in what they take to lie outside. Catmull-Rom is a = -0.5;
/// OpenCV's bicubic is the same formula with a = -0.75: it shows that the formula and the pixel centres are right.
const SCRIPT: &str = "
import sys
import numpy as np, cv2, OpenImageIO as oiio
h, w = 150, 200
source, offsets, cubic, lanczos = [np.fromfile(path, np.float32) for path in sys.argv[1:]]
source, cubic, lanczos = [plane.reshape(h, w) for plane in (source, cubic, lanczos)]
offsets = offsets.reshape(h, w, 2)
y, x = np.mgrid[0:h, 0:w].astype(float)
place = np.stack([x, y], -1) + offsets

def keys(t, a):
    near, far = (a + 2) * t**3 - (a + 3) * t**2 + 1, a * t**3 - 5 * a * t**2 + 8 * a * t - 4 * a
    return np.where(t < 1, near, np.where(t < 2, far, 0))

def sinc3(t):
    return np.where(t < 3, np.sinc(t) * np.sinc(t / 3), 0)

def filtered(profile, taps):
    base = np.floor(place).astype(int)
    sums, weights = np.zeros((h, w)), np.zeros((h, w))
    for dy in range(1 - taps, taps + 1):
        for dx in range(1 - taps, taps + 1):
            weight = profile(abs(base[..., 0] + dx - place[..., 0])) * profile(abs(base[..., 1] + dy - place[..., 1]))
            sums += weight * source[np.clip(base[..., 1] + dy, 0, h - 1), np.clip(base[..., 0] + dx, 0, w - 1)]
            weights += weight
    return sums / weights

def buffer(pixels):
    made = oiio.ImageBuf(oiio.ImageSpec(w, h, pixels.shape[2], oiio.FLOAT))
    made.set_pixels(made.roi, pixels.astype(np.float32))
    return made

def gap(a, b):
    return abs(a - b)[12:-12, 12:-12].max() / abs(source).max()

opencv = cv2.remap(source, place.astype(np.float32), None, cv2.INTER_CUBIC)
st = (place + 0.5) / [w, h]
theirs = oiio.ImageBufAlgo.st_warp(buffer(source[..., None]), buffer(st), 'catmull-rom').get_pixels(oiio.FLOAT)[..., 0]
print(gap(opencv, filtered(lambda t: keys(t, -0.75), 2)))
print(gap(cubic, filtered(lambda t: keys(t, -0.5), 2)))
print(gap(cubic, theirs))
print(gap(lanczos, filtered(sinc3, 3)))
print(gap(cubic, opencv))
";

/// Waves and noise; places on multiples of 1/32 pixel, since OpenCV rounds to them.
fn warp() -> (Vec<f32>, WarpMap) {
    let noise = |k: usize| ((k as f32 * 12.9898).sin() * 43_758.547).fract();
    let source = (0..FRAME.window().area()).map(|k| (0.05 * (k % 200) as f32).sin() + noise(k)).collect();
    let mut map = WarpMap::identity(FRAME, FRAME.window());
    for (index, to) in map.offsets.iter_mut().enumerate() {
        let (x, y) = ((index % 200) as f32, (index / 200) as f32);
        *to = [3.0 * (0.11 * y + 0.05 * x).sin(), 4.0 * (0.09 * x).cos()].map(|x| (32.0 * x).round() / 32.0);
    }
    (source, map)
}

fn write(folder: &Path, name: &str, numbers: &[f32]) -> std::path::PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytemuck::cast_slice(numbers)).unwrap();
    path
}

#[test]
fn filters_are_those_of_other_programs() {
    let (source, map) = warp();
    let planes = Planes { window: FRAME.window(), planes: vec![&source] };
    let [cubic, lanczos] = [Filter::Cubic, Filter::Lanczos].map(|filter| resampled(&map, &planes, filter).remove(0));
    let folder = tempfile::tempdir().unwrap();
    let parts =
        [("source", &source[..]), ("offsets", map.offsets.as_flattened()), ("cubic", &cubic), ("lanczos", &lanczos)];
    let paths = parts.map(|(name, numbers)| write(folder.path(), name, numbers));
    let arguments: Vec<_> = paths.iter().map(|path| path.as_os_str()).collect();
    let Some(answer) = python::run(&["numpy", "cv2", "OpenImageIO"], SCRIPT, &arguments) else { return };
    let gaps: Vec<f64> = answer.lines().map(|line| line.trim().parse().unwrap()).collect();
    let [opencv, cubic, openimageio, lanczos, other] = gaps[..] else { panic!("{answer}") };
    assert!(opencv < 1e-6, "the formula is not OpenCV's: {opencv:e}");
    assert!(cubic < 1e-6, "cubic: {cubic:e}");
    // The map that OpenImageIO reads, 0 to 1 in single precision, is that far off.
    assert!(openimageio < 3e-5, "cubic beside OpenImageIO: {openimageio:e}");
    assert!(lanczos < 5e-6, "lanczos: {lanczos:e}");
    assert!(other > 1e-2, "the comparison cannot fail: {other:e}");
}

/// A row or column at the border of the map is on another surface than the one beside it: the step to its only neighbour is no slope.
#[test]
fn a_tear_at_the_border_of_the_map_does_not_widen_the_filter() {
    let (source, _) = warp();
    let [width, height] = [FRAME.width as usize, FRAME.height as usize];
    for (name, by) in [("top", 2.0), ("bottom", -2.0), ("left", 2.0), ("right", -2.0)] {
        let is_apart = |x: usize, y: usize| match name {
            "top" => y == 0,
            "bottom" => y + 1 == height,
            "left" => x == 0,
            _ => x + 1 == width,
        };
        let mut map = WarpMap::identity(FRAME, FRAME.window());
        for (index, offset) in map.offsets.iter_mut().enumerate() {
            *offset = if is_apart(index % width, index / width) { [by; 2] } else { [20.0 * by; 2] };
        }
        let planes = Planes { window: FRAME.window(), planes: vec![&source] };
        let moved = resampled(&map, &planes, Filter::Ewa);
        for step in 10..height - 10 {
            let [x, y] = [(step, 0), (step, height - 1), (0, step), (width - 1, step)]
                .map(|(x, y)| [x, y])
                .into_iter()
                .find(|&[x, y]| is_apart(x, y))
                .expect("one side");
            let wanted = source[(y as f32 + by) as usize * width + (x as f32 + by) as usize];
            let found = moved[0][y * width + x];
            assert!((found - wanted).abs() < 1e-5, "{name}, {step}: {found}, not {wanted}");
        }
    }
}
