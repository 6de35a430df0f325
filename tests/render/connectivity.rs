//! What a shot cuts and joins of a scene under a branching lattice.

use super::tiny::{Part, Tiny, grid};
use pinwarp::pipeline::PreparedShot;
use pinwarp::shot::Shot;
use pinwarp::solve::Topology;
use pinwarp::space::ScreenPoint;

/// A body and an arm beside it, with `gap` metres between them; the arm has the second material.
fn prepared(gap: f32, lattice: &str) -> Result<PreparedShot, String> {
    let parts = vec![grid("Body", [-0.3, -0.45, 0.0, 0.45], 12), grid("Arm", [gap, -0.45, gap + 0.12, 0.3], 12)];
    prepared_of(parts, gap, lattice)
}

/// The same of other parts.
fn prepared_of(parts: Vec<Part>, gap: f32, lattice: &str) -> Result<PreparedShot, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let names = ["Coat", "Sleeve"].iter().take(parts.len()).enumerate();
    let mut scene = Tiny::of(parts).json();
    for (material, name) in names {
        scene["materials"][material]["name"] = (*name).into();
    }
    std::fs::write(folder.path().join("tiny.gltf"), scene.to_string()).expect("written");
    // Screen points are 0.5 above and right of those of the scene.
    let pin = |[x, y]: [f64; 2], [dx, dy]: [f64; 2]| {
        format!(
            "[[layer.pin]]\nanchor = {{ screen = [{x}, {y}], frame = 1 }}\nkeys = [{{ frame = 1, offset = [{dx}, {dy}] }}]\n"
        )
    };
    let held = [[0.25, 0.1], [0.25, 0.9], [0.45, 0.9], [0.45, 0.1]].map(|at| pin(at, [0.0; 2])).concat();
    let pulled = pin([f64::from(gap) + 0.56, 0.15], [0.15, 0.05]);
    let text = format!(
        "version = 1\nscene = 'tiny.gltf'\nframes = {{ first = 1, last = 2, rate = 24 }}\nsize = [256, 256]\n[[layer]]\n\
         lattice = {{ dims = [20, 20], topology = 'branching', {lattice} }}\n{held}{pulled}"
    );
    let shot = Shot::parse(&text, &folder.path().join("shot.toml")).map_err(|error| error.to_string())?;
    PreparedShot::new(shot).map_err(|error| error.to_string())
}

/// How far the border of the body moves that the arm is beside, pixels.
fn body_moves(gap: f32, lattice: &str) -> f64 {
    border_moves(&prepared(gap, lattice).expect("a right shot"))
}

/// The same of a prepared shot.
fn border_moves(prepared: &PreparedShot) -> f64 {
    moves_at(prepared, 1..8)
}

/// The same at some tenths of a frame height above the lower end of the body's border.
fn moves_at(prepared: &PreparedShot, tenths: std::ops::Range<u32>) -> f64 {
    let sample = prepared.sample_at(1.0).expect("solvable");
    let solution = sample.layers[0].solution.as_ref().expect("its pins act");
    let triangles = prepared.scene.meshes[0].primitives[0].triangles.len();
    let moved = |y: f64| {
        let at = ScreenPoint::new(0.4999, y);
        let to = match &solution.branches {
            // The triangle does not matter for a point of a piece: all of them belong to the body.
            Some(branches) => branches.warp(0..triangles, at.0.to_array()),
            None => solution.lattice.warp(at).0.to_array(),
        };
        (to[0] - at.0.x).hypot(to[1] - at.0.y) * 256.0
    };
    tenths.map(|k| moved(0.1 + 0.1 * f64::from(k))).fold(0.0, f64::max)
}

#[test]
fn a_part_that_touches_is_cut_off_by_its_name() {
    let whole = body_moves(0.0, "cuts = []");
    let cuts = ["{ nodes = ['Arm'] }", "{ materials = ['Sleeve'] }", "{ nodes = ['Arm'], materials = ['Sleeve*'] }"];
    for cut in cuts {
        let apart = body_moves(0.0, &format!("cuts = [{cut}]"));
        println!("the body moves by {whole:.2} px as one piece, by {apart:.2} px with {cut}");
        assert!(apart < 0.5 && whole > 10.0 * apart, "{cut}: {whole} as one piece, {apart} apart");
    }
}

#[test]
fn a_stroke_over_the_scene_cuts_off_what_it_divides() {
    let whole = body_moves(0.0, "cuts = []");
    let apart = body_moves(0.0, "cuts = [{ stroke = [[0.5, 0.02], [0.5, 0.9]], frame = 1 }]");
    println!("the body moves by {whole:.2} px as one piece, by {apart:.2} px after a stroke");
    assert!(apart < 0.5 && whole > 10.0 * apart, "{whole} as one piece, {apart} apart");
}

#[test]
fn a_stroke_is_drawn_over_the_frame_that_it_names() {
    let moving = |lattice: &str| {
        let mut parts = vec![grid("Body", [-0.3, -0.45, 0.0, 0.45], 12), grid("Arm", [0.0, -0.45, 0.12, 0.3], 12)];
        parts.iter_mut().for_each(|part| part.velocity = [0.5, 0.0, 0.0]);
        prepared_of(parts, 0.0, lattice)
    };
    // In half a second the border moves from 0.5 to 0.75.
    let stroke = |frame: i32| format!("cuts = [{{ stroke = [[0.75, 0.02], [0.75, 0.9]], frame = {frame} }}]");
    let outside = moving(&stroke(13)).expect("a right shot");
    let apart = border_moves(&outside);
    assert!(apart < 0.5, "{apart}");
    let note = "layer 'layer1': the stroke of cuts[0] is drawn over frame 13, outside the shot's frames 1 to 2";
    assert!(outside.notes.iter().any(|told| told == note), "{:?}", outside.notes);
    let told = moving(&stroke(1)).expect_err("nothing is there");
    assert!(told.contains("cuts nothing in frame 1") && told.contains("cuts[0]"), "{told}");
}

#[test]
fn a_stroke_opens_the_surface_of_one_mesh_on_request() {
    let one = |open: &str| {
        let stroke = format!("cuts = [{{ stroke = [[0.5, 0.02], [0.5, 0.9]], frame = 1{open} }}]");
        prepared_of(vec![grid("All", [-0.3, -0.45, 0.12, 0.45], 21)], 0.0, &stroke)
    };
    let told = one("").expect_err("the surface stays whole");
    assert!(told.contains("cuts nothing") && told.contains("open = true"), "{told}");
    one(", open = true").expect("it opens");
}

#[test]
fn islands_hang_on_what_is_near_and_on_what_they_are_joined_to() {
    let [near, far, joined] =
        ["island_radius = 0.1", "island_radius = 0.01", "island_radius = 0.01, joins = [['Arm', 'Bod*']]"]
            .map(|lattice| body_moves(0.03, lattice));
    println!(
        "the body moves by {near:.2} px beside an island, {far:.2} px beside one too far, {joined:.2} px joined by hand"
    );
    assert!(far < 0.5 && near > 2.0 * far && (joined - near).abs() < 1e-6, "{near} {far} {joined}");
}

#[test]
fn a_part_hangs_where_a_join_names_the_place() {
    // The arm is pulled at its lower end.
    let [at_hand, at_shoulder] = ["at = [0.02, -0.35, 0.0]", "at = [0.02, 0.29, 0.0]"].map(|at| {
        let lattice = format!("cuts = [{{ nodes = ['Arm'] }}], joins = [{{ nodes = ['Arm', 'Body'], {at} }}]");
        prepared(0.03, &lattice).expect("a right shot")
    });
    let [low, high] = [&at_hand, &at_shoulder].map(|prepared| moves_at(prepared, 1..3));
    println!(
        "beside the hand the body moves by {low:.2} px with a join there, by {high:.2} px with one at the shoulder"
    );
    assert!(low > 1.0 && high < 0.5 * low, "{low} and {high}");
    let moved = moves_at(&at_shoulder, 6..7);
    assert!(moved > 0.1, "the arm pulls at the shoulder: {moved}");
}

#[test]
fn a_join_that_undoes_a_cut_is_noted() {
    let noted = |join: &str| {
        let prepared = prepared(0.0, &format!("cuts = [{{ nodes = ['Arm'] }}], joins = [{join}]")).expect("right");
        prepared.notes.iter().any(|note| note.contains("joins[0] links 'Arm' and 'Body' again, which a cut separates"))
    };
    assert!(noted("['Arm', 'Body']"));
    assert!(!noted("{ nodes = ['Arm', 'Body'], at = [0.0, 0.3, 0.0] }"));
    let only_joined = prepared(0.03, "island_radius = 0.01, joins = [['Arm', 'Body']]").expect("right");
    assert!(!only_joined.notes.iter().any(|note| note.contains("again")), "{:?}", only_joined.notes);
}

#[test]
fn cuts_and_joins_without_effect_are_reported() {
    for (lattice, parts) in [
        ("cuts = [{ nodes = ['Leg'] }]", ["no node matches 'Leg'", "cuts[0].nodes"]),
        ("cuts = [{ nodes = ['*'] }]", ["separates nothing", "cuts[0]"]),
        ("cuts = [{ joints = ['Hand'] }]", ["skin", "cuts[0].joints"]),
        ("cuts = [{ materials = ['Slieve'] }]", ["did you mean", "cuts[0].materials"]),
        ("cuts = [{ mask = { file = 'no.png' } }]", ["there is no file", "cuts[0].mask.file"]),
        ("cuts = [{}]", ["separates nothing", "cuts[0]"]),
        ("cuts = [[[0, 0], [1, 1]]]", ["needs the frame in which it is drawn", "cuts[0]"]),
        ("cuts = [{ stroke = [[0.9, 0.1], [0.9, 0.2]], frame = 1 }]", ["cuts nothing in frame 1", "cuts[0]"]),
        ("cuts = [{ stroke = [[0.5, 0.1], [0.5, 0.2]] }]", ["is missing", "cuts[0].frame"]),
        ("cuts = [{ nodes = ['Arm'], frame = 2 }]", ["belongs to `stroke`", "cuts[0].frame"]),
        ("cuts = [{ stroke = [[0, 0], [1, 1]], frame = 1, nodes = ['Arm'] }]", ["stands alone", "cuts[0].nodes"]),
        ("cuts = [{ ids = { file = 'ids.png' } }]", ["divides pictures", "cuts[0].ids"]),
        ("cuts = [{ regions = {} }]", ["divides pictures", "cuts[0].regions"]),
        ("joins = [['Arm', 'Bdy']]", ["no node of the layer", "joins[0]"]),
        ("joins = [['Arm', 'Ar*']]", ["joined with itself", "joins[0]"]),
        ("island_radius = -1.0", ["island_radius", "-1"]),
    ] {
        let told = prepared(0.0, lattice).map(|_| String::new()).unwrap_or_else(|error| error);
        assert!(parts.iter().all(|part| told.contains(part)), "{lattice}: {told}");
    }
    let plain = prepared(0.0, "cuts = []").expect("right");
    assert_eq!(plain.shot.layers[0].connectivity.island_radius, 0.1);
}

#[test]
fn lattices_of_a_scene_branch_unless_it_is_too_fine_or_has_lines() {
    let prepared = |cells: u32, mode: u32, lattice: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        let mut scene = Tiny::of(vec![grid("All", [-0.3, -0.45, 0.3, 0.45], cells)]).json();
        scene["meshes"][0]["primitives"][0]["mode"] = mode.into();
        std::fs::write(folder.path().join("tiny.gltf"), scene.to_string()).expect("written");
        let text = format!(
            "version = 1\nscene = 'tiny.gltf'\nframes = {{ first = 1, last = 2, rate = 24 }}\nsize = [64, 64]\n[[layer]]\n\
             name = 'all'\nlattice = {{ {lattice} }}\n"
        );
        let shot = Shot::parse(&text, &folder.path().join("shot.toml")).expect("a right shot");
        PreparedShot::new(shot).expect("a scene")
    };
    const FINE: u32 = 225;
    const TRIANGLES: u32 = 4;
    const LINE_STRIP: u32 = 3;
    for (cells, mode, lattice, wanted, note) in [
        (12, TRIANGLES, "", Topology::Branching, None),
        (12, LINE_STRIP, "", Topology::Plain, None),
        (FINE, TRIANGLES, "", Topology::Plain, Some("101250 triangles")),
        (FINE, TRIANGLES, "topology = 'plain'", Topology::Plain, None),
        (
            FINE,
            TRIANGLES,
            "cuts = [{ stroke = [[0.5, 0], [0.5, 1]], frame = 1, open = true }]",
            Topology::Branching,
            None,
        ),
    ] {
        let prepared = prepared(cells, mode, lattice);
        assert_eq!(prepared.shot.layers[0].settings.topology, wanted, "{cells} {mode} {lattice}");
        let is_told = |told: &&String| told.contains("its lattice is plain");
        let told = prepared.notes.iter().find(is_told);
        assert_eq!(told.is_some(), note.is_some(), "{told:?}");
        assert!(note.is_none_or(|note| told.is_some_and(|told| told.contains(note))), "{told:?}");
    }
}
