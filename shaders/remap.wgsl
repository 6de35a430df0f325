// Resamples planes through a map of offsets: the GPU version of src/plate/filter/, with one invocation per pixel of an
// area.
//
// In: offsets of the area and its neighbours, a part of the source, Lanczos weights. Out: planes of the area.
// Samples are read and written as bits, so that copies preserve them and no driver has to be relied upon to handle
// NaNs.

/// Replaces infinities: 65504, the largest finite half, as bits.
const MAX_HALF: u32 = 0x477fe000u;
/// Smallest fraction of the weights that must fall on numbers for a sum to be used.
const MIN_PRESENCE: f32 = 0.25;
/// Largest minification that is filtered in full.
const SHRINK_LIMIT: f32 = 16.0;
/// Minifications up to this factor are ignored.
const MIN_MINIFICATION: f32 = 1.02;
/// Entries per sample spacing in the table of Lanczos weights, and numbers per row of the table.
const STEPS: i32 = 1024;
const ROW: i32 = 8;
/// Larger than all samples.
const HUGE: f32 = 3.4028234e38;

/// Parameters of an area; 80 bytes.
struct Push {
    /// Size of the area in pixels.
    area: vec2<u32>,
    /// Position of the area's first pixel among the offsets, and their number across and down.
    first: vec2<i32>,
    offset_count: vec2<i32>,
    /// The sample that zero offset gives to the first pixel.
    start: vec2<i32>,
    /// Number of samples of the whole picture, across and down.
    count: vec2<i32>,
    /// The part of the picture in `source`: first sample and size.
    low: vec2<i32>,
    size: vec2<i32>,
    /// Per axis, 1 if the picture continues with its border samples before the first and after the last sample, 0 if it
    /// ends.
    goes_on_before: vec2<u32>,
    goes_on_after: vec2<u32>,
    /// Number of consecutive planes in source and result, 1 to 4.
    planes: u32,
    padding: u32,
}

/// Position of a pixel in the source: the sample before it, and the fraction of a sample beyond that.
struct Place {
    sample: vec2<i32>,
    fraction: vec2<f32>,
    is_near: bool,
}

/// Map from source to filter distances (xx, xy = yx, yy), and half extents of the filter's square of "radius" 1 in the
/// source.
struct Shape {
    filter_from_source: vec3<f32>,
    reach: vec2<f32>,
}

var<immediate> push: Push;
@group(0) @binding(0) var<storage, read> offsets: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read> source: array<u32>;
@group(0) @binding(2) var<storage, read> lanczos_table: array<f32>;
@group(0) @binding(3) var<storage, read_write> result: array<u32>;

/// Whether a NaN was read.
var<private> found_nan: bool;
/// Whether texels are read as presence: 1 for numbers, 0 for NaNs.
var<private> reads_presence: bool;

fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

fn is_nan(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u;
}

// --- Samples: border.rs, block.rs -----------------------------------------------------------------------------------

/// Bits of up to four planes at a sample, which may be outside the picture.
fn bits_at(place: vec2<i32>) -> vec4<u32> {
    let before = (place < vec2<i32>(0)) & (push.goes_on_before == vec2<u32>(1u));
    let after = (place >= push.count) & (push.goes_on_after == vec2<u32>(1u));
    let sample = select(place, clamp(place, vec2<i32>(0), push.count - 1), before | after);
    var bits = vec4<u32>(0u);
    if any(sample < vec2<i32>(0)) || any(sample >= push.count) {
        return bits;
    }
    // `source` contains every sample that is needed; the clamp prevents reads elsewhere should that be violated.
    let here = clamp(sample - push.low, vec2<i32>(0), push.size - 1);
    let index = here.y * push.size.x + here.x;
    let area = push.size.x * push.size.y;
    bits.x = source[index];
    if push.planes > 1u { bits.y = source[index + area]; }
    if push.planes > 2u { bits.z = source[index + 2 * area]; }
    if push.planes > 3u { bits.w = source[index + 3 * area]; }
    return bits;
}

/// Samples as finite numbers, with 0 for NaNs; or their presence, 1 or 0.
fn texel_at(place: vec2<i32>) -> vec4<f32> {
    let bits = bits_at(place);
    let magnitude = bits & vec4<u32>(0x7fffffffu);
    let is_nan = magnitude > vec4<u32>(0x7f800000u);
    found_nan = found_nan || any(is_nan);
    if reads_presence {
        return select(vec4<f32>(1.0), vec4<f32>(0.0), is_nan);
    }
    let greatest = (bits & vec4<u32>(0x80000000u)) | vec4<u32>(MAX_HALF);
    let finite = select(bits, greatest, magnitude == vec4<u32>(0x7f800000u));
    return bitcast<vec4<f32>>(select(finite, vec4<u32>(0u), is_nan));
}

/// Distance in pixels over which a border may be pulled into the picture and still counts as resting.
const RESTING: f32 = 0.001953125;

/// Least width of an output pixel in the picture, in samples, that counts where the warp magnifies.
const NARROWEST: f32 = 0.015625;

/// The same in pixels of the result, where the warp magnifies without limit.
const UNSURE: f32 = 0.125;

/// How far a position lies beyond the last samples on the sides where the picture continues, at most 1; 0 elsewhere.
fn excess(place: Place) -> vec2<f32> {
    let sample = vec2<f32>(place.sample);
    let before = select(vec2<f32>(0.0), -sample - place.fraction, push.goes_on_before == vec2<u32>(1u));
    let rest = sample + place.fraction - vec2<f32>(push.count - 1);
    let after = select(vec2<f32>(0.0), rest, push.goes_on_after == vec2<u32>(1u));
    return clamp(max(before, after), vec2<f32>(0.0), vec2<f32>(1.0));
}

/// Fraction of a pixel inside those borders at which the picture ends, 0 to 1.
fn coverage(pixel: vec2<i32>, place: Place) -> f32 {
    let beyond = excess(place);
    if all(beyond == vec2<f32>(0.0)) {
        return 1.0;
    }
    let width = pixel_width(pixel);
    let inside = clamp((0.5 - beyond) / width + 0.5, vec2<f32>(0.0), vec2<f32>(1.0));
    let resting = RESTING + UNSURE * (1.0 - width);
    let both = max(inside, min(2.0 * inside - (1.0 - 2.0 * resting), vec2<f32>(1.0)));
    return select(both.x, 1.0, beyond.x == 0.0) * select(both.y, 1.0, beyond.y == 0.0);
}

/// Width of an output pixel along both axes of the picture, in samples, at most 1.
fn pixel_width(pixel: vec2<i32>) -> vec2<f32> {
    let across = slope(pixel, vec2<i32>(1, 0));
    let down = slope(pixel, vec2<i32>(0, 1));
    return clamp(sqrt(across * across + down * down), vec2<f32>(NARROWEST), vec2<f32>(1.0));
}

/// Least change of both coordinates of the picture along an axis of the map, without its sign, at most 1.
fn slope(pixel: vec2<i32>, step: vec2<i32>) -> vec2<f32> {
    var least = vec2<f32>(1.0);
    let before = offset_step(pixel - step, step);
    let before_next = offset_step(pixel - 2 * step, step);
    if before_next.is_known && before.is_known {
        least = min(least, least_slope(before.by + vec2<f32>(step), before_next.by + vec2<f32>(step)));
    }
    let after = offset_step(pixel, step);
    let after_next = offset_step(pixel + step, step);
    if after.is_known && after_next.is_known {
        least = min(least, least_slope(after.by + vec2<f32>(step), after_next.by + vec2<f32>(step)));
    }
    return least;
}

/// Least slope between a pixel's centre and its far side: `least_slope` in border.rs.
fn least_slope(near: vec2<f32>, next: vec2<f32>) -> vec2<f32> {
    return min(abs(near), abs(1.75 * near - 0.75 * next));
}

// --- Places: places.rs, nearest.rs ----------------------------------------------------------------------------------

fn offset_at(pixel: vec2<i32>) -> vec2<f32> {
    let at = push.first + pixel;
    return bitcast<vec2<f32>>(offsets[at.y * push.offset_count.x + at.x]);
}

fn is_still(pixel: vec2<i32>) -> bool {
    return all((bitcast<vec2<u32>>(offset_at(pixel)) & vec2<u32>(0x7fffffffu)) == vec2<u32>(0u));
}

/// Position of a pixel in the source. With `taps` filter taps on each side, positions farther from the picture are not
/// near.
fn place_of(pixel: vec2<i32>, taps: f32) -> Place {
    let offset = offset_at(pixel);
    if !is_finite(offset.x) || !is_finite(offset.y) {
        return Place(vec2<i32>(0), vec2<f32>(0.0), false);
    }
    let whole = floor(offset);
    let sample = vec2<f32>(push.start + pixel) + whole;
    if any(sample < vec2<f32>(-taps)) || any(sample >= vec2<f32>(push.count) + taps) {
        return Place(vec2<i32>(0), vec2<f32>(0.0), false);
    }
    return Place(vec2<i32>(sample), offset - whole, true);
}

/// Bits of the sample nearest to a pixel's source position; 0 outside the picture.
fn nearest_sample(pixel: vec2<i32>) -> vec4<u32> {
    let offset = offset_at(pixel);
    if !is_finite(offset.x) || !is_finite(offset.y) {
        return vec4<u32>(0u);
    }
    let place = vec2<f32>(push.start + pixel) + floor(offset + 0.5);
    if any(place < vec2<f32>(0.0)) || any(place >= vec2<f32>(push.count)) {
        return vec4<u32>(0u);
    }
    return bits_at(vec2<i32>(place));
}

// --- Footprints: shape.rs -------------------------------------------------------------------------------------------

/// A difference of two neighbouring offsets.
struct OffsetStep {
    by: vec2<f32>,
    is_known: bool,
}

/// The difference from a pixel to the next along an axis; unknown outside the map.
fn offset_step(pixel: vec2<i32>, step: vec2<i32>) -> OffsetStep {
    let at = push.first + pixel;
    if any(at < vec2<i32>(0)) || any(at + step >= push.offset_count) {
        return OffsetStep(vec2<f32>(0.0), false);
    }
    let by = offset_at(pixel + step) - offset_at(pixel);
    return OffsetStep(by, !is_nan(by.x) && !is_nan(by.y));
}

/// Offsets that change by less than this per pixel are on one surface: `TEAR` in footprint.rs.
const TEAR: f32 = 0.5;

/// Whether a change of the offsets is steep and differs from the next one on the same side, as across a tear.
fn is_torn(by: OffsetStep, next: OffsetStep) -> bool {
    let gap = by.by - next.by;
    let is_steep = dot(by.by, by.by) > TEAR * TEAR;
    return next.is_known && is_steep && dot(gap, gap) > TEAR * TEAR * max(dot(next.by, next.by), 1.0);
}

/// The shorter of two differences; the other if one is unknown, 0 if both are.
fn shorter(before: OffsetStep, after: OffsetStep) -> vec2<f32> {
    if before.is_known && (!after.is_known || dot(before.by, before.by) <= dot(after.by, after.by)) {
        return before.by;
    }
    return select(vec2<f32>(0.0), after.by, after.is_known);
}

/// Derivative of the offsets along an axis, per pixel: the shorter of the differences to both neighbours that does not
/// cross a tear. At the border of the map the next difference stands for the missing one. 0 if there is none.
fn steepness(pixel: vec2<i32>, step: vec2<i32>) -> vec2<f32> {
    let at = push.first + pixel;
    let is_first = any(at - step < vec2<i32>(0));
    let is_last = any(at + step >= push.offset_count);
    var before = offset_step(select(pixel - step, pixel + step, is_first), step);
    var after = offset_step(select(pixel, pixel - 2 * step, is_last), step);
    let least = shorter(before, after);
    if dot(least, least) <= TEAR * TEAR {
        return least;
    }
    before.is_known = before.is_known && !is_torn(before, offset_step(pixel - 2 * step, step));
    after.is_known = after.is_known && !is_torn(after, offset_step(pixel + step, step));
    return shorter(before, after);
}

fn shape_at(pixel: vec2<i32>) -> Shape {
    let across = steepness(pixel, vec2<i32>(1, 0));
    let down = steepness(pixel, vec2<i32>(0, 1));
    return shape_of_jacobian(vec2<f32>(1.0 + across.x, down.x), vec2<f32>(across.y, 1.0 + down.y));
}

/// The footprint H⁻¹ from the rows of J, H = max(1, √(J Jᵀ)).
fn shape_of_jacobian(x: vec2<f32>, y: vec2<f32>) -> Shape {
    let a = dot(x, x);
    let b = dot(x, y);
    let c = dot(y, y);
    let mean = 0.5 * (a + c);
    let half = 0.5 * (a - c);
    let radius = sqrt(half * half + b * b);
    let longest = mean + radius;
    if longest <= MIN_MINIFICATION * MIN_MINIFICATION || !is_finite(longest) {
        return Shape(vec3<f32>(1.0, 0.0, 1.0), vec2<f32>(1.0));
    }
    let long = clamped_scale(longest);
    let short = clamped_scale(mean - radius);
    let scale = select(0.0, 1.0 / radius, radius > 0.0);
    let along = half * scale;
    let aside = b * scale;
    let p = 0.5 * (1.0 / long + 1.0 / short);
    let q = 0.5 * (1.0 / long - 1.0 / short);
    let s = 0.5 * (long + short);
    let t = 0.5 * (long - short);
    let corner = abs(t * aside);
    let matrix = vec3<f32>(p + q * along, q * aside, p - q * along);
    return Shape(matrix, vec2<f32>(s + t * along, s - t * along) + corner);
}

fn clamped_scale(squared: f32) -> f32 {
    return clamp(sqrt(max(squared, 0.0)) / MIN_MINIFICATION, 1.0, SHRINK_LIMIT);
}

fn is_unit(shape: Shape) -> bool {
    return all(shape.reach == vec2<f32>(1.0));
}

// --- Weights: profile.rs --------------------------------------------------------------------------------------------

/// Catmull-Rom weights of the samples at -1, 0, 1 and 2.
fn cubic_weights(fraction: f32) -> vec4<f32> {
    let c0 = vec4<f32>(0.0, 1.0, 0.0, 0.0);
    let c1 = vec4<f32>(-0.5, 0.0, 0.5, 0.0);
    let c2 = vec4<f32>(1.0, -2.5, 2.0, -0.5);
    let c3 = vec4<f32>(-0.5, 1.5, -1.5, 0.5);
    return ((c3 * fraction + c2) * fraction + c1) * fraction + c0;
}

/// Lanczos weight of the `tap`-th sample, counted from the one at -2.
fn lanczos_weight(fraction: f32, tap: i32) -> f32 {
    let place = fraction * f32(STEPS);
    let step = min(i32(place), STEPS - 1);
    let low = lanczos_table[step * ROW + tap];
    let high = lanczos_table[(step + 1) * ROW + tap];
    return (place - f32(step)) * (high - low) + low;
}

/// The Catmull-Rom kernel at a distance.
fn catmull_rom(distance: f32) -> f32 {
    let t = abs(distance);
    let u = min(t, 2.0);
    let near = (1.5 * t - 2.5) * (t * t) + 1.0;
    let far = ((-0.5 * u + 2.5) * u - 4.0) * u + 2.0;
    return select(far, near, t < 1.0);
}

// --- Sums: kernel.rs ------------------------------------------------------------------------------------------------

fn cubic_row(first: vec2<i32>, across: vec4<f32>) -> vec4<f32> {
    return across.x * texel_at(first)
        + across.y * texel_at(first + vec2<i32>(1, 0))
        + across.z * texel_at(first + vec2<i32>(2, 0))
        + across.w * texel_at(first + vec2<i32>(3, 0));
}

fn cubic_sum(place: Place) -> vec4<f32> {
    let first = place.sample - 1;
    let across = cubic_weights(place.fraction.x);
    let down = cubic_weights(place.fraction.y);
    return down.x * cubic_row(first, across)
        + down.y * cubic_row(first + vec2<i32>(0, 1), across)
        + down.z * cubic_row(first + vec2<i32>(0, 2), across)
        + down.w * cubic_row(first + vec2<i32>(0, 3), across);
}

fn lanczos_sum(place: Place) -> vec4<f32> {
    let first = place.sample - 2;
    var sum = vec4<f32>(0.0);
    for (var y = 0; y < 6; y++) {
        var row = vec4<f32>(0.0);
        for (var x = 0; x < 6; x++) {
            row += lanczos_weight(place.fraction.x, x) * texel_at(first + vec2<i32>(x, y));
        }
        sum += lanczos_weight(place.fraction.y, y) * row;
    }
    return sum;
}

/// Clamps to a range. An empty range does not clamp.
fn hold(value: vec4<f32>, low: vec4<f32>, high: vec4<f32>) -> vec4<f32> {
    return select(value, max(min(value, high), low), low <= high);
}

/// Catmull-Rom interpolation, clamped to the range of the four texels around the position.
fn cubic_clamped(place: Place) -> vec4<f32> {
    let a = texel_at(place.sample);
    let b = texel_at(place.sample + vec2<i32>(1, 0));
    let c = texel_at(place.sample + vec2<i32>(0, 1));
    let d = texel_at(place.sample + vec2<i32>(1, 1));
    return hold(cubic_sum(place), min(min(a, b), min(c, d)), max(max(a, b), max(c, d)));
}

/// Interval of a row inside the filter's square of "radius" 2 and its extents, relative to the position.
fn chord(shape: Shape, dy: f32) -> vec2<f32> {
    let xx = shape.filter_from_source.x;
    let xy = shape.filter_from_source.y;
    let yy = shape.filter_from_source.z;
    let reach = 2.0 * shape.reach.x;
    var cut = vec2<f32>(-xy * dy - 2.0, -xy * dy + 2.0) / xx;
    // The second pair of edges is nearly parallel to the row and never limits it.
    if abs(xy) >= 1e-5 {
        let middle = -yy / xy * dy;
        let half = 2.0 / abs(xy);
        cut = vec2<f32>(max(cut.x, middle - half), min(cut.y, middle + half));
    }
    return vec2<f32>(max(cut.x, -reach), min(cut.y, reach));
}

/// Catmull-Rom filter along the axes of an enlarged footprint, normalised and clamped to the range of its inner square.
fn cubic_footprint(place: Place, shape: Shape) -> vec4<f32> {
    let xx = shape.filter_from_source.x;
    let xy = shape.filter_from_source.y;
    let yy = shape.filter_from_source.z;
    let reach = 2.0 * shape.reach.y;
    var sum = vec4<f32>(0.0);
    var weight_sum = 0.0;
    var low = vec4<f32>(HUGE);
    var high = vec4<f32>(-HUGE);
    let bottom = i32(floor(place.fraction.y + reach));
    for (var y = i32(ceil(place.fraction.y - reach)); y <= bottom; y++) {
        let dy = f32(y) - place.fraction.y;
        let cut = chord(shape, dy);
        let last = i32(floor(place.fraction.x + cut.y));
        for (var x = i32(ceil(place.fraction.x + cut.x)); x <= last; x++) {
            let dx = f32(x) - place.fraction.x;
            let u = xx * dx + xy * dy;
            let v = xy * dx + yy * dy;
            let weight = catmull_rom(u) * catmull_rom(v);
            let texel = texel_at(place.sample + vec2<i32>(x, y));
            sum += weight * texel;
            weight_sum += weight;
            if max(abs(u), abs(v)) < 1.0 {
                low = min(low, texel);
                high = max(high, texel);
            }
        }
    }
    return hold(sum / weight_sum, low, high);
}

fn footprint_sum(place: Place, shape: Shape) -> vec4<f32> {
    if is_unit(shape) {
        return cubic_clamped(place);
    }
    return cubic_footprint(place, shape);
}

// --- Pixels: tile.rs ------------------------------------------------------------------------------------------------

fn write_bits(pixel: vec2<i32>, bits: vec4<u32>) {
    let index = u32(pixel.y) * push.area.x + u32(pixel.x);
    let area = push.area.x * push.area.y;
    result[index] = bits.x;
    if push.planes > 1u { result[index + area] = bits.y; }
    if push.planes > 2u { result[index + 2u * area] = bits.z; }
    if push.planes > 3u { result[index + 3u * area] = bits.w; }
}

fn write(pixel: vec2<i32>, place: Place, sum: vec4<f32>) {
    write_bits(pixel, bitcast<vec4<u32>>(sum * coverage(pixel, place)));
}

/// Distributes the weights of NaN samples over the others; 0 if too few are numbers.
fn renormalize(sum: vec4<f32>, presence: vec4<f32>) -> vec4<f32> {
    let is_valid = presence >= vec4<f32>(MIN_PRESENCE);
    return select(vec4<f32>(0.0), sum / select(vec4<f32>(1.0), presence, is_valid), is_valid);
}

@compute @workgroup_size(8, 8)
fn nearest(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= push.area) {
        return;
    }
    write_bits(vec2<i32>(id.xy), nearest_sample(vec2<i32>(id.xy)));
}

@compute @workgroup_size(8, 8)
fn cubic(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= push.area) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let place = place_of(pixel, 2.0);
    if is_still(pixel) || !place.is_near {
        write_bits(pixel, nearest_sample(pixel) * vec4<u32>(u32(is_still(pixel))));
        return;
    }
    var sum = cubic_sum(place);
    if found_nan {
        reads_presence = true;
        sum = renormalize(sum, cubic_sum(place));
    }
    write(pixel, place, sum);
}

@compute @workgroup_size(8, 8)
fn lanczos(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= push.area) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let place = place_of(pixel, 3.0);
    if is_still(pixel) || !place.is_near {
        write_bits(pixel, nearest_sample(pixel) * vec4<u32>(u32(is_still(pixel))));
        return;
    }
    var sum = lanczos_sum(place);
    if found_nan {
        reads_presence = true;
        sum = renormalize(sum, lanczos_sum(place));
    }
    write(pixel, place, sum);
}

@compute @workgroup_size(8, 8)
fn ewa(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= push.area) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let shape = shape_at(pixel);
    let is_copied = is_still(pixel) && is_unit(shape);
    let place = place_of(pixel, floor(2.0 * max(shape.reach.x, shape.reach.y)) + 1.0);
    if is_copied || !place.is_near {
        write_bits(pixel, nearest_sample(pixel) * vec4<u32>(u32(is_copied)));
        return;
    }
    var sum = footprint_sum(place, shape);
    if found_nan {
        reads_presence = true;
        sum = renormalize(sum, footprint_sum(place, shape));
    }
    write(pixel, place, sum);
}
