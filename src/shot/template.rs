//! The commented shot that `pinwarp new` writes.
//!
//! In: facts about a scene. Out: a text that can be rendered unchanged, and that explains further options.

use crate::files::GENERATOR;
use crate::space::FrameSize;
use toml_edit::Value;

/// The facts about a scene that the template uses.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TemplateFacts {
    /// The subject of the shot.
    pub subject: Subject,
    /// Whether the lattice of a scene can branch in good time: the scene has no lines, and not too many triangles.
    pub can_branch: bool,
    /// Names of the cameras, in order; unnamed ones are omitted.
    pub cameras: Vec<String>,
    /// Whether the scene has a camera, named or not.
    pub has_camera: bool,
    /// Names and durations of the clips, in order.
    pub clips: Vec<ClipFact>,
    /// Names of the nodes with meshes.
    pub mesh_nodes: Vec<String>,
    /// Names of alternative nodes of a character pack, such as several weapons in one place: candidates for `hide`.
    pub spare_nodes: Vec<String>,
    /// First and last frame.
    pub frames: [i32; 2],
    /// Frames per second.
    pub rate: f64,
    /// The frame size.
    pub size: FrameSize,
}

/// The subject of a shot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Subject {
    /// A glTF scene.
    Scene,
    /// A picture.
    Image,
}

/// A clip as the template lists it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClipFact {
    /// Its name, or its index as text if it has none.
    pub name: String,
    /// Its duration in seconds.
    pub secs: f64,
}

/// Clips per comment line.
const CLIPS_PER_LINE: usize = 5;

/// Maximum number of names listed in a comment.
const LISTED_NAMES: usize = 12;

/// Returns a commented, working shot of `scene_file`, a path relative to the shot file.
#[must_use]
pub(crate) fn write(scene_file: &str, facts: &TemplateFacts) -> String {
    let (head, output) = match facts.subject {
        Subject::Scene => (head(scene_file, facts), OUTPUT),
        Subject::Image => (image_head(scene_file, facts), IMAGE_OUTPUT),
    };
    [head, layer(facts), output.to_owned()].join("\n")
}

fn head(scene_file: &str, facts: &TemplateFacts) -> String {
    let [first, last] = facts.frames;
    let FrameSize { width, height, pixel_aspect } = facts.size;
    let scene = quoted(scene_file);
    let camera = camera(facts);
    let clips = clips(facts);
    let hide = hide(facts);
    let rate = facts.rate;
    format!(
        "## A shot of {GENERATOR}: a scene, its frames, and layers whose pins bend what the camera sees.
## Two # begin an explanation, one # a line to use: take the # away.
## Lengths on the screen are in frame heights, y up: [0, 0] is the lower left corner, [{aspect:.3}, 1] the upper right.
version = 1
scene   = {scene}
{camera}
{hide}{clips}
frames  = {{ first = {first}, last = {last}, rate = {rate}{clip_start} }}
solve_range = [{first}, {last}]           # over which frames are solved together; keep it where you trim `frames`
size    = [{width}, {height}]
{pixel_aspect}samples = 16                              # more: smoother edges and blur, slower
shutter = {{ angle = 180, phase = -90 }}    # motion blur centred on the frame; angle = 0: none
# environment = 1.0                       # neutral light from around; default: only where the scene has no lights
# exposure = 0.0                          # all lights, in stops
# step = 2                                # pins move on twos
# strength = 1.0                          # all pins at once; 0: no warp
",
        aspect = facts.size.aspect(),
        // Without it the clip starts in the first frame, so trimming would shift it.
        clip_start = if facts.clips.is_empty() { String::new() } else { format!(", clip_start = {first}") },
        pixel_aspect = if pixel_aspect == 1.0 { String::new() } else { format!("pixel_aspect = {pixel_aspect:?}\n") },
    )
}

fn image_head(image_file: &str, facts: &TemplateFacts) -> String {
    let [first, last] = facts.frames;
    let FrameSize { width, height, .. } = facts.size;
    format!(
        "## A shot of {GENERATOR}: a picture, its frames, and layers whose pins bend it.
## Two # begin an explanation, one # a line to use: take the # away.
## Lengths on the screen are in frame heights, y up: [0, 0] is the lower left corner, [{aspect:.3}, 1] the upper right.
version = 1
image   = {image}
##        several of one size, from back to front: image = [\"back.png\", \"hair.png\"]; each is a node of its own
frames  = {{ first = {first}, last = {last}, rate = {rate} }}
solve_range = [{first}, {last}]           # over which frames are solved together; keep it where you trim `frames`
# size  = [{width}, {height}]             # default: the size of the picture
# shutter = {{ angle = 180, phase = -90 }}  # motion blur centred on the frame; angle = 0: none
# samples = 16                            # moments of the blur; more: smoother, slower
# warp  = {{ filter = \"ewa\" }}            # or \"cubic\", \"lanczos\", \"nearest\"
# step = 2                                # pins move on twos
# strength = 1.0                          # all pins at once; 0: no warp
",
        aspect = facts.size.aspect(),
        image = quoted(image_file),
        rate = facts.rate,
    )
}

/// The camera options of a scene without cameras.
const NO_CAMERA: &str = "## The scene has no camera: one that shows the whole scene is used. Others:
##        camera = \"front\", or back, left, right, top, bottom, three-quarter
# camera = { look_at = [0.0, 1.0, 0.0], distance = 4.0, yaw = 30, pitch = 10, fov = 30 }";

fn camera(facts: &TemplateFacts) -> String {
    match facts.cameras.as_slice() {
        [] if facts.has_camera => "## The scene's first camera is used.".to_owned(),
        [] => NO_CAMERA.to_owned(),
        [only] => format!("camera  = {}", quoted(only)),
        [first, ..] => format!("## Cameras: {}\ncamera  = {}", listed(&facts.cameras), quoted(first)),
    }
}

/// Suggests nodes of a pack to hide; empty if there are no candidates.
fn hide(facts: &TemplateFacts) -> String {
    if facts.spare_nodes.is_empty() {
        return String::new();
    }
    let names: Vec<String> = facts.spare_nodes.iter().map(|name| quoted(name)).collect();
    format!(
        "## Several things hang in one place, as in packs of characters; those listed here are not drawn. `show` brings back:\n\
         # hide = [{}]\n# show = [{}]\n",
        names.join(", "),
        names[0]
    )
}

fn clips(facts: &TemplateFacts) -> String {
    if facts.clips.is_empty() {
        return "## The scene has no animation; pins can move all the same.".to_owned();
    }
    let clip = |clip: &ClipFact| format!("{} ({:.2} s)", quoted(&clip.name), clip.secs);
    let clips: Vec<String> = facts.clips.iter().map(clip).collect();
    // All clips are listed, as the user chooses from them.
    let lines: Vec<String> = clips.chunks(CLIPS_PER_LINE).map(|clips| clips.join(", ")).collect();
    format!("## Clips: {}; the first is used.\n## In frames: clip = \"..\", loop = true.", lines.join(",\n##        "))
}

fn layer(facts: &TemplateFacts) -> String {
    let nodes = if facts.mesh_nodes.is_empty() { "none".to_owned() } else { listed(&facts.mesh_nodes) };
    let node = quoted(facts.mesh_nodes.first().map_or("Node", String::as_str));
    let [first, last] = facts.frames;
    let middle = f64::midpoint(f64::from(first), f64::from(last)).floor();
    let center = (facts.size.aspect() * 500.0).round() / 1000.0;
    // A shot of a single frame has room for one key only.
    let is_moving = middle > f64::from(first);
    let later = if is_moving { pin_key(middle) } else { String::new() };
    let handle_later = if is_moving { format!(", {{ frame = {middle}, offset = [0.0, 0.1] }}") } else { String::new() };
    let handle = format!(
        "  ## A handle of the lattice moved by hand, in sizes of its box:
  # [[layer.handle]]
  # index = [9, 4]
  # keys  = [ {{ frame = {first}, offset = [0.0, 0.0] }}{handle_later} ]
"
    );
    let (lattice, region, handle) = match facts.subject {
        Subject::Scene if facts.can_branch => (SCENE_LATTICE, REGION, ""),
        Subject::Scene => (PLAIN_LATTICE, REGION, handle.as_str()),
        // Handle indices have as many numbers as dims, which an automatic lattice does not have.
        Subject::Image => (IMAGE_LATTICE, IMAGE_REGION, ""),
    };
    format!(
        "## One lattice bends everything in a layer. Nodes with meshes: {nodes}
[[layer]]
name    = \"all\"
# nodes = [{node}]
##        names with * and ?, each with what hangs below it; default: everything
# solve = {{ guard = \"report\" }}          # folds are reported, not prevented; preset = \"paper\" instead is the method as published
# step = 1                              # instead of the shot's
# strength = 1.0                        # times the shot's
{lattice}
  ## A pin. `pinwarp pick SHOT --frame {first} --at X,Y` prints one for the surface seen there:
  ##   anchor = {{ node = {node}, primitive = 0, triangle = 0, barycentric = [0.2, 0.5, 0.3] }}
  ## A pin without keys holds its place. Instead of offsets all keys may give a target: a place on the screen.
  # [[layer.pin]]
  # name   = \"pin1\"
  # anchor = {{ screen = [{center:?}, 0.5], frame = {first} }}      # follows the surface seen there in frame {first}
  # unit   = \"frame\"                         # or \"box\": offsets in sizes of the lattice's box
{region}  # keys   = [ {{ frame = {first}, offset = [0.0, 0.0], ease = {{ bezier = [0.4, 0.0, 0.2, 1.0] }} }},{later} ]

  ## Parts that keep their shape more than the rest: nodes, a material, or a channel of the vertex colours (\"r\").
  # [[layer.stiffness]]
  # nodes = [{node}]
  # value = 4.0

{handle}",
    )
}

/// Returns the second key of the example, on a line of its own.
fn pin_key(frame: f64) -> String {
    format!(
        "
  #            ## degrees counter-clockwise, and a scale; ease shapes what leaves its key: hold, linear, smooth, bezier
  #            {{ frame = {frame}, offset = [0.05, 0.1], rotate = 10.0, scale = 1.1 }}"
    )
}

/// The lattice options of a scene.
const SCENE_LATTICE: &str = "## Parts that are apart on the model move apart, also where they cross on the screen; dims fit the thinnest of them.
## Faster, where what is close together may move together:
## lattice = { dims = [10, 10], topology = \"plain\" }
## In the scene instead of on the screen: it bends the meshes, pins move in metres (three numbers) or on the screen (two).
## lattice = { space = \"world\", dims = [5, 5, 5], box = \"follow\" }
lattice = { dims = \"auto\", topology = \"branching\", box = \"follow\" }

";

/// The lattice options of a scene whose lattice cannot branch, or takes long to.
const PLAIN_LATTICE: &str = "## In the scene instead of on the screen: it bends the meshes, pins move in metres (three numbers) or on the screen (two).
## lattice = { space = \"world\", dims = [5, 5, 5], box = \"follow\" }
lattice = { dims = [10, 10], basis = \"bspline\", box = \"follow\" }

";

/// The lattice options of a drawing, whose parts are close to each other.
const IMAGE_LATTICE: &str = "## What is close together moves together:
## lattice = { dims = [10, 10], topology = \"plain\" }
## Parts that are close to each other move apart; dims fit the thinnest of them.
lattice = { dims = \"auto\" }

";

/// The region options of a drawing, including the depth order.
const IMAGE_REGION: &str = "  # region = { radius = 0.1, rigidity = 1.0, stiffness = 1.0 }   # takes what is around it along as one piece, stiffens it
  # order  = 1                              # the part around it lies in front of others; [{ frame = 9, value = -1 }]: from frame 9 behind
";

/// The region options of a pin.
const REGION: &str = "  # region = { radius = 0.1, rigidity = 1.0, stiffness = 1.0 }   # takes what is around it along as one piece, stiffens it
";

const IMAGE_OUTPUT: &str = "[output]
# path = \"out/shot.####.exr\"              # default: out/<name of this file>.####.exr
channels = [\"beauty\", \"id\"]
# compression = \"zip\"                     # none, rle, zips, zip, piz, dwaa, dwab
";

const OUTPUT: &str = "[output]
# path = \"out/shot.####.exr\"              # default: out/<name of this file>.####.exr
channels = [\"beauty\", \"depth\", \"motion\", \"normal\", \"id\"]
# compression = \"zip\"                     # none, rle, zips, zip, piz, dwaa, dwab
";

/// Returns a TOML string on one line, so that it can be placed in a comment.
fn quoted(text: &str) -> String {
    let toml = Value::from(text).to_string();
    // JSON's escapes are valid in TOML.
    if toml.contains('\n') { serde_json::Value::from(text).to_string() } else { toml }
}

fn listed(names: &[String]) -> String {
    let mut listed: Vec<String> = names.iter().take(LISTED_NAMES).map(|name| quoted(name)).collect();
    if names.len() > LISTED_NAMES {
        listed.push(format!("and {} more", names.len() - LISTED_NAMES));
    }
    listed.join(", ")
}
