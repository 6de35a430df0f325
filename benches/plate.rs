//! Warps of finished frames next to OpenCV and OpenImageIO, measured in one run: `cargo bench --bench plate`.
//!
//! Needs Python 3 with numpy, opencv-python and OpenImageIO (`PYTHON` names another interpreter), and a Vulkan device;
//! prints a message if they are missing. Rows of the Vulkan device include the transfers. All rows of a size run in turn and
//! the fastest run of each counts, so that other load on the computer affects all rows alike.

use pinwarp::lattice::{Basis, Grid};
use pinwarp::plate::{Field, Filter, Planes, WarpMap, resample_into, resampled};
use pinwarp::raster::DeviceChoice;
use pinwarp::raster::vulkan::VulkanRemap;
use pinwarp::space::FrameSize;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

/// Smallest and largest number of runs per row.
const RUNS: [usize; 2] = [2, 25];
/// A row is not run again after this many milliseconds in total.
const ENOUGH_MS: f64 = 3000.0;

/// A warp to time.
struct Case {
    frame: FrameSize,
    map: WarpMap,
    /// The field of a lattice of 10 x 10 handles over the whole frame.
    field: Field,
    planes: Vec<Vec<f32>>,
}

/// One row of the table.
struct Row {
    name: &'static str,
    run: Run,
}

#[derive(Clone, Copy)]
enum Run {
    /// Computing the map of a field.
    Map,
    /// Resampling by pinwarp into allocated memory.
    Ours(Filter),
    /// Resampling by pinwarp into new memory.
    Fresh(Filter),
    /// Resampling by pinwarp on the Vulkan device.
    Device(Filter),
    /// Resampling by a package: its name and the filter.
    Peer(&'static str),
}

impl Case {
    /// A picture of noise on waves, and a smooth warp that scales by up to a tenth and rotates slightly.
    fn new(width: u32, height: u32) -> Self {
        let frame = FrameSize::new(width, height);
        let mut map = WarpMap::identity(frame, frame.window());
        for (index, to) in map.offsets.iter_mut().enumerate() {
            let x = (index % width as usize) as f32 / width as f32;
            let y = (index / width as usize) as f32 / width as f32;
            let size = 0.016 * width as f32;
            *to = [size * (6.3 * y + 2.0 * x).sin(), size * (6.3 * x + 1.0 * y).cos()];
        }
        let sample = |k: usize| (0.001 * k as f32).sin() + 0.5 * ((k as f32 * 12.9898).sin() * 43_758.547).fract();
        let plane = |p: usize| (0..frame.window().area()).map(|k| sample(k + 7919 * p)).collect();
        Self { frame, map, field: field(frame), planes: (0..4).map(plane).collect() }
    }

    fn source(&self) -> Planes<'_> {
        Planes { window: self.frame.window(), planes: self.planes.iter().map(Vec::as_slice).collect() }
    }

    /// Writes the input of the Python script: interleaved samples and offsets.
    fn write(&self, folder: &Path) {
        let area = self.frame.window().area();
        let texels: Vec<f32> =
            (0..area).flat_map(|k| (0..4).map(move |p| (p, k))).map(|(p, k)| self.planes[p][k]).collect();
        std::fs::write(folder.join("source"), bytemuck::cast_slice(&texels))
            .expect("a temporary folder can be written");
        let offsets = bytemuck::cast_slice(&self.map.offsets);
        std::fs::write(folder.join("offsets"), offsets).expect("a temporary folder can be written");
    }
}

/// A smooth warp of the whole picture, by up to a twentieth of its height.
fn field(frame: FrameSize) -> Field {
    let mut lattice =
        Grid { dims: [10, 10], basis: Basis::Bspline, lo: [0.0; 2], hi: [frame.aspect(), 1.0], angle: 0.0 }.at_rest();
    for (k, handle) in lattice.handles.iter_mut().enumerate() {
        let k = k as f64;
        *handle = [handle[0] + 0.05 * (0.9 * k).sin(), handle[1] + 0.05 * (1.7 * k).cos()];
    }
    Field::of_picture(lattice)
}

/// The Python process that times the other packages.
struct Peers {
    child: Child,
    ask: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Peers {
    fn start(case: &Case, folder: &Path) -> Option<Self> {
        let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/plate.py");
        let sizes = [case.frame.width, case.frame.height].map(|size| size.to_string());
        let mut command = Command::new(python);
        command.arg(script).args(sizes).arg(folder.join("source")).arg(folder.join("offsets"));
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().ok()?;
        let (ask, answers) = (child.stdin.take()?, BufReader::new(child.stdout.take()?));
        Some(Self { child, ask, answers })
    }

    /// Milliseconds of one run; NaN if the process does not answer.
    fn time(&mut self, what: &str, threads: usize) -> f64 {
        let mut answer = String::new();
        let asked = writeln!(self.ask, "{what} {threads}").and_then(|()| self.answers.read_line(&mut answer));
        asked.ok().and_then(|_| answer.trim().parse().ok()).unwrap_or(f64::NAN)
    }

    fn stop(mut self) {
        drop(self.ask);
        let _ = self.child.wait();
    }
}

/// The other packages and the Vulkan device, as far as they are available.
struct Others {
    peers: Option<Peers>,
    device: Option<VulkanRemap>,
}

fn rows() -> Vec<Row> {
    let row = |name, run| Row { name, run };
    vec![
        row("map of a 10x10 lattice", Run::Map),
        row("nearest", Run::Ours(Filter::Nearest)),
        row("cubic", Run::Ours(Filter::Cubic)),
        row("cubic, fresh memory", Run::Fresh(Filter::Cubic)),
        row("lanczos (6x6)", Run::Ours(Filter::Lanczos)),
        row("ewa", Run::Ours(Filter::Ewa)),
        row("Vulkan nearest", Run::Device(Filter::Nearest)),
        row("Vulkan cubic", Run::Device(Filter::Cubic)),
        row("Vulkan lanczos (6x6)", Run::Device(Filter::Lanczos)),
        row("Vulkan ewa", Run::Device(Filter::Ewa)),
        row("OpenCV nearest", Run::Peer("opencv nearest")),
        row("OpenCV bilinear", Run::Peer("opencv linear")),
        row("OpenCV bicubic", Run::Peer("opencv cubic")),
        row("OpenCV lanczos (8x8)", Run::Peer("opencv lanczos")),
        row("OpenImageIO catmull-rom", Run::Peer("openimageio cubic")),
        row("OpenImageIO lanczos3", Run::Peer("openimageio lanczos")),
    ]
}

/// Milliseconds of one run of a row.
fn time(run: Run, case: &Case, pool: &ThreadPool, outputs: &mut [Vec<f32>], others: &mut Others) -> f64 {
    let source = case.source();
    let start = Instant::now();
    match run {
        Run::Map => drop(pool.install(|| WarpMap::backward(&case.field, case.frame, case.frame.window()))),
        Run::Ours(filter) => pool.install(|| resample_into(&case.map, &source, filter, outputs)),
        Run::Fresh(filter) => drop(pool.install(|| resampled(&case.map, &source, filter))),
        Run::Device(filter) => {
            let drawn = others.device.as_mut().map(|device| device.resample(&case.map, &source, filter));
            if !matches!(drawn, Some(Ok(_))) {
                return f64::NAN;
            }
        }
        Run::Peer(what) => {
            return others.peers.as_mut().map_or(f64::NAN, |peers| peers.time(what, pool.current_num_threads()));
        }
    }
    start.elapsed().as_secs_f64() * 1e3
}

/// The fastest run of every row with this number of threads.
fn measure(case: &Case, threads: usize, others: &mut Others) -> Vec<f64> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can be started");
    let mut outputs = vec![vec![0.0; case.frame.window().area()]; 4];
    let rows = rows();
    let (mut fastest, mut spent) = (vec![f64::INFINITY; rows.len()], vec![0.0; rows.len()]);
    for run in 0..RUNS[1] {
        for (k, row) in rows.iter().enumerate() {
            if run < RUNS[0] || spent[k] < ENOUGH_MS {
                let time = time(row.run, case, &pool, &mut outputs, others);
                fastest[k] = fastest[k].min(time);
                spent[k] += time;
            }
        }
    }
    fastest
}

fn main() {
    for (width, height) in [(1920, 1080), (3840, 2160)] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let case = Case::new(width, height);
        case.write(folder.path());
        let device = VulkanRemap::open(&DeviceChoice::Vulkan);
        match &device {
            Ok(device) => println!("Vulkan: {}", device.name()),
            Err(error) => println!("SKIPPED: {error}"),
        }
        let mut others = Others { peers: Peers::start(&case, folder.path()), device: device.ok() };
        if others.peers.is_none() {
            println!(
                "SKIPPED: no peers; pip install numpy opencv-python OpenImageIO, and name the interpreter in PYTHON"
            );
        }
        let [one, two] = [1, 2].map(|threads| measure(&case, threads, &mut others));
        println!("{width}x{height}, RGBA float, ms{:>14}{:>12}", "1 thread", "2 threads");
        for ((row, one), two) in rows().iter().zip(one).zip(two) {
            println!("  {:<28}{one:>12.1}{two:>12.1}", row.name);
        }
        others.peers.into_iter().for_each(Peers::stop);
    }
}
