//! Names of files with unusual letters. `export`: names, sizes and layers that an output format does not have are refused before
//! anything is solved.

use crate::support::{Bench, HEAD, OUTPUT, PIN, names_in};

#[test]
fn files_with_the_sign_of_a_counter_in_their_names_are_read() {
    let bench = Bench::plain();
    let picture = image::RgbaImage::from_pixel(64, 36, image::Rgba([200, 100, 50, 255]));
    picture.save(bench.path("girl#2.png")).expect("saved");
    bench.run("new girl#2.png -o girl.toml").says(0, &[]);
    bench.run("render girl.toml --device cpu --frames 1 -o g.####.exr").says(0, &["frame 1 -> g.0001.exr"]);
    for plate in ["girl#2.png", "shade.####.png", "100%.png"] {
        picture.save(bench.path(plate)).expect("saved");
        bench.run(&format!("warp {plate} --shot shot.toml -o w.##.png --overwrite")).says(0, &["frame 2 -> w.02.png"]);
    }
    let pin = "[[layer]]\n[[layer.pin]]\nanchor = { screen = [0.5, 0.5] }\n";
    let shot = format!("plate = \"girl#2.png\"\nframes = {{ first = 1, last = 2 }}\n{pin}");
    bench.write("plate.toml", shot.as_bytes());
    bench.run("warp --shot plate.toml -o p.####.png").says(0, &["frame 2 -> p.0002.png"]);
    // What is not there is a sequence.
    bench.run("new girl#3.png -o g.toml").says(2, &["single images, but this is a sequence"]);
}

#[test]
fn frames_and_maps_are_named_after_shots_of_any_name() {
    let bench = Bench::with_shot(&format!("{HEAD}{PIN}"));
    std::fs::create_dir(bench.path("take#1")).expect("a folder");
    std::fs::copy(bench.path("tiny.gltf"), bench.path("take#1/tiny.gltf")).expect("copied");
    for (name, plain) in [("s#1", "s_1"), ("s%04d", "s_04d"), ("sh_v2_100%", "sh_v2_100_"), ("take#1/s", "take#1/s")] {
        let shot = format!("{name}.toml");
        std::fs::copy(bench.path("shot.toml"), bench.path(&shot)).expect("copied");
        let (folder, stem) = plain.rsplit_once('/').map_or(("", plain), |(folder, stem)| (folder, stem));
        let frame = bench.path(folder).join(format!("out/{stem}.0002.exr"));
        bench.run(&format!("check {shot}")).says(0, &[]);
        bench.run(&format!("render {shot} --device cpu")).says(0, &[]);
        assert!(frame.exists(), "{shot}");
        for format in ["stmap", "after-effects"] {
            bench.run(&format!("export {shot} --to {format}")).says(0, &[]);
        }
        bench.run(&format!("export {shot} --to nuke --overwrite")).says(0, &[]);
        for ending in ["stmap.0002.exr", "all.element.0002.exr", "all.after-effects.txt"] {
            assert!(bench.path(&format!("{plain}.{ending}")).exists(), "{shot}: {ending}");
        }
        let script = String::from_utf8(bench.read(&format!("{name}.nk"))).expect("text");
        assert!(script.contains(&format!("file \"{stem}.stmap.####.exr\"")), "{script}");
    }
    bench.run("export shot.toml --to after-effects -o x#1").says(2, &["-o x#1: ", "without a frame counter"]);
}

#[test]
fn outputs_have_the_extension_of_their_format() {
    let bench = Bench::new();
    bench.run("export shot.toml --to lattice-json -o l.json").says(0, &[]);
    let before = names_in(&bench.path("."));
    let wrong = [
        ("stmap", "x.png", "--to stmap writes .exr files; name the output -o x.exr"),
        ("stmap", "st/m.####.png", ".exr files; name the output -o st/m.####.exr"),
        ("stmap", "m.####.tif", "name the output -o m.####.tif.exr"),
        ("nuke", "comp.exr", "--to nuke writes .nk files; name the output -o comp.nk"),
        ("blender", "x.glb", "--to blender writes .py files; name the output -o x.py"),
        ("blender", "x.blend", "name the output -o x.blend.py"),
        ("gltf", "x.gltf", "--to gltf writes .glb files; name the output -o x.glb"),
        ("gltf", "shot.v2", "name the output -o shot.v2.glb"),
        ("lattice-json", "x.nk", "--to lattice-json writes .json files; name the output -o x.json"),
        ("after-effects", "x.exr", "writes several files; give the start of their names without an extension, -o x"),
    ];
    for (format, output, says) in wrong {
        bench.run(&format!("export shot.toml --to {format} -o {output}")).says(2, &[&format!("-o {output}: "), says]);
    }
    bench.run("export l.json --to stmap -o x.png").says(2, &["writes .exr files"]);
    assert_eq!(names_in(&bench.path(".")), before, "nothing was written");
    for (format, output) in
        [("stmap", "m.####.EXR"), ("gltf", "X.GLB"), ("lattice-json", "bare"), ("after-effects", "shot.v2")]
    {
        bench.run(&format!("export shot.toml --to {format} -o {output}")).says(0, &[]);
    }
}

#[test]
fn maps_have_the_shape_of_the_shot() {
    let bench = Bench::new();
    let says = ["--size 100x100 is 1.0000 wide to 1 high, shot.toml is 1.7778 to 1", "such as 100x56 or 178x100"];
    for format in ["stmap", "nuke", "after-effects"] {
        bench.run(&format!("export shot.toml --to {format} --size 100x100")).says(2, &says);
    }
    bench.run("export shot.toml --to stmap --size 100x56 -o a.####.exr").says(0, &[]);
    bench.run("export shot.toml --to stmap --size 1920x1080 --frames 2 -o b.####.exr").says(0, &[]);
    // A shot of wide pixels has maps of wide pixels.
    bench.write(
        "wide.toml",
        format!("{HEAD}{PIN}{OUTPUT}").replace("[64, 36]", "[32, 36]\npixel_aspect = 2").as_bytes(),
    );
    bench.run("export wide.toml --to stmap --size 64x36").says(2, &["3.5556 wide to 1 high", "32x36"]);
    bench.run("export wide.toml --to stmap --size 64x72 -o c.####.exr").says(0, &[]);
    // A lattice file knows the shape of the frame only.
    bench.run("export shot.toml --to lattice-json").says(0, &[]);
    let says = ["note: --size 32x36 is 0.8889 wide", "for pixels that are 2.0000 wide to 1 high"];
    bench.run("export shot.lattice.json --to stmap --size 32x36 -o d.####.exr").says(0, &says);
}

#[test]
fn pictures_are_not_taken_for_maps() {
    // Shaded, so that its colours vary.
    let bench = Bench::with_shot(&format!("{HEAD}{PIN}{OUTPUT}").replace("samples = 1", "samples = 4"));
    bench.render("").says(0, &[]);
    let says = ["out/f.0001.exr: the picture is a render of pinwarp and not an STMap", "export --to stmap"];
    bench.run("warp out/f.####.exr --stmap out/f.####.exr -o w.####.exr").says(2, &says);
    assert!(!bench.path("w.0001.exr").exists());
    // A picture of another program may be meant: it is used, with a warning.
    let beige = image::RgbImage::from_pixel(64, 36, image::Rgb([200, 180, 160]));
    beige.save(bench.path("beige.png")).expect("saved");
    let says = ["warning:", "\"beige.png\" is probably not an STMap", "check --stmap"];
    bench.run("warp out/f.####.exr --stmap beige.png -o w.####.exr").says(0, &says);
    // Maps pass, folded and with overscan.
    bench.run("export shot.toml --to stmap --overscan 30 -o m.####.exr").says(0, &[]);
    let told = bench.run("warp out/f.####.exr --stmap m.####.exr -o v.####.exr").says(0, &[]);
    assert!(!told.stderr.contains("probably not"), "{}", told.stderr);
}
