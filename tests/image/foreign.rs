//! OpenEXR and OpenImageIO open what we write, and find in it what we put there.

use super::assets::asset;
use super::python;
use super::support::{ALL, metadata, sample_frame};
use half::f16;
use pinwarp::image::{Channel, Plate, Storage, read_plate, write_exr, write_plate};
use pinwarp::space::PixelRect;
use std::fmt::Write;
use std::path::Path;

/// Prints, for each part: name, view, windows; for each channel: name, kind and the sum of its samples' bits; texts.
const OPENEXR: &str = r"
import sys, numpy, OpenEXR
def window(header, name):
    (x, y), (right, bottom) = header[name]
    return f'{x} {y} {right - x + 1} {bottom - y + 1}'
kinds = {'float16': ('half', 'u2'), 'float32': ('float', 'u4'), 'uint32': ('uint', 'u4')}
for part in OpenEXR.File(sys.argv[1], separate_channels=True).parts:
    header = part.header
    print('part', header.get('name', '-'), header.get('view', '-'), window(header, 'dataWindow'),
          window(header, 'displayWindow'), '%.4f' % header['pixelAspectRatio'])
    for name in sorted(part.channels):
        pixels = numpy.ascontiguousarray(part.channels[name].pixels)
        kind, bits = kinds[str(pixels.dtype)]
        print('channel', name, kind, pixels.view(bits).sum(dtype='u8'))
    for name in sorted(name for name in header if name.startswith('cryptomatte/')):
        print('text', name, header[name])
";

/// The same from OpenImageIO.
const OPENIMAGEIO: &str = r"
import sys, numpy, OpenImageIO as oiio
source = oiio.ImageInput.open(sys.argv[1])
part = 0
while source.seek_subimage(part, 0):
    spec = source.spec()
    print('part', spec.getattribute('name') or '-', spec.getattribute('view') or '-', spec.x, spec.y, spec.width, spec.height,
          spec.full_x, spec.full_y, spec.full_width, spec.full_height, '%.4f' % spec.getattribute('PixelAspectRatio'))
    lines = []
    for index, name in enumerate(spec.channelnames):
        kind = str(spec.channelformat(index))
        pixels = numpy.ascontiguousarray(source.read_image(part, 0, index, index + 1, kind))
        bits = 'u2' if kind == 'half' else 'u4'
        lines.append(f'channel {name} {kind} {pixels.view(bits).sum(dtype=numpy.uint64)}')
    print('\n'.join(sorted(lines)))
    for name in sorted(a.name for a in spec.extra_attribs if a.name.startswith('cryptomatte/')):
        print('text', name, spec.getattribute(name))
    part += 1
";

/// What the scripts have to print of a plate.
fn expected(plate: &Plate) -> String {
    let mut told = String::new();
    let window = |window: PixelRect| format!("{} {} {} {}", window.x, window.y, window.width, window.height);
    for part in &plate.parts {
        let (name, view) = (part.name.as_deref().unwrap_or("-"), part.view.as_deref().unwrap_or("-"));
        let windows = (window(part.data_window), window(plate.display));
        writeln!(told, "part {name} {view} {} {} {:.4}", windows.0, windows.1, plate.pixel_aspect).expect("a string");
        let mut channels: Vec<_> = part.channels.iter().map(told_channel).collect();
        channels.sort();
        told += &channels.concat();
        for (name, value) in part.texts("cryptomatte/") {
            writeln!(told, "text {name} {value}").expect("a string");
        }
    }
    told
}

fn told_channel(channel: &Channel) -> String {
    let bits = channel.samples.iter().map(|sample| match channel.storage {
        Storage::Half => u64::from(f16::from_f32(*sample).to_bits()),
        Storage::Float | Storage::Uint => u64::from(sample.to_bits()),
    });
    let kind = match channel.storage {
        Storage::Half => "half",
        Storage::Float => "float",
        Storage::Uint => "uint",
    };
    format!("channel {} {kind} {}\n", channel.name, bits.sum::<u64>())
}

/// Both readers find what the plate holds; `None` where they are not there.
fn check(path: &Path, plate: &Plate) -> Option<()> {
    let expected = expected(plate);
    for (module, script) in [("OpenEXR", OPENEXR), ("OpenImageIO", OPENIMAGEIO)] {
        let found = python::run(&["numpy", module], script, &[path.as_os_str()])?;
        assert!(found == expected, "{module} found\n{found}in a file of\n{expected}");
    }
    Some(())
}

#[test]
fn others_find_all_of_a_rendered_frame() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for compression in ALL {
        let path = folder.path().join(format!("{compression:?}.exr"));
        write_exr(&path, &sample_frame(), &metadata(), compression).expect("written");
        // Decoders of lossy files may differ in the last bit.
        let is_read = if compression.is_lossy() {
            python::run(&["OpenEXR"], "import sys, OpenEXR; OpenEXR.File(sys.argv[1])", &[path.as_os_str()]).map(drop)
        } else {
            check(&path, &read_plate(&path).expect("just written"))
        };
        let Some(()) = is_read else { return };
    }
}

#[test]
fn others_find_all_of_a_plate() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("plate.exr");
    let mut plate = Plate::from_frame(sample_frame());
    let window = plate.parts[0].data_window;
    let more = plate.parts[0].channels.clone();
    let mut left = plate.parts[0].with_channels(window, more);
    left.name = Some("links.größer".into());
    left.view = Some("left".into());
    left.channels[0].name = "a name of more than thirty-one bytes.R".replace(' ', "_");
    left.set_text("cryptomatte/f834d0a/manifest", "{\"Bälle\":\"0a0b0c0d\"}");
    left.set_text("cryptomatte/f834d0a/name", "CryptoObject");
    plate.parts[0].name = Some("rgba".into());
    plate.parts.push(left);
    write_plate(&path, &plate).expect("written");
    if check(&path, &plate).is_none() {
        return;
    }
    // The check can fail.
    plate.parts[1].channels[0].samples[7] += 1.0;
    assert!(std::panic::catch_unwind(|| check(&path, &plate)).is_err());
}

#[test]
fn others_find_all_of_real_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("again.exr");
    for file in ["Beachball/multipart.0002.exr", "DisplayWindow/t16.exr", "ScanLines/CandleGlass.exr"] {
        let Some(original) = asset(&format!("openexr-images/{file}")) else { return };
        let plate = read_plate(&original).expect(file);
        write_plate(&path, &plate).expect("written");
        if check(&path, &plate).is_none() {
            return;
        }
    }
}

/// Texture files: tiles stay, of the levels the largest is kept, and said so.
#[test]
fn tiled_files_of_others_stay_tiled() {
    const MAKE: &str = r"
import sys, numpy, OpenImageIO as oiio
pixels = numpy.random.default_rng(5).random((50, 70, 3)).astype('f4')
picture = oiio.ImageBuf(pixels)
assert oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, picture, sys.argv[1])
";
    const TILES: &str = r"
import sys, OpenEXR
header = OpenEXR.File(sys.argv[1]).header()
print(header['type'], header['tiles'].xSize, header['tiles'].ySize, header['tiles'].mode)
";
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (path, again) = (folder.path().join("mip.exr"), folder.path().join("again.exr"));
    let Some(_) = python::run(&["numpy", "OpenImageIO", "OpenEXR"], MAKE, &[path.as_os_str()]) else { return };
    let plate = read_plate(&path).expect("a texture");
    assert_eq!(plate.parts[0].data_window, PixelRect { x: 0, y: 0, width: 70, height: 50 });
    assert!(plate.left_out[0].contains("the smaller mip levels"), "{:?}", plate.left_out);
    write_plate(&again, &plate).expect("written");
    assert_eq!(check(&again, &plate), Some(()));
    let tiles = |path: &Path| python::run(&["OpenEXR"], TILES, &[path.as_os_str()]).expect("it ran before");
    let (before, after) = (tiles(&path), tiles(&again));
    assert!(before.contains("MIPMAP") && after.contains("ONE_LEVEL"), "{before}{after}");
    assert_eq!(before.split(' ').nth(1), after.split(' ').nth(1));
}
