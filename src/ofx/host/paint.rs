//! Line drawing over the viewer: by the host's Draw suite, else by OpenGL 1, looked up in the process at run time.
//!
//! In: points, canonical, and a colour. Out: lines on the screen; nothing if the host has neither.

use crate::ofx::api::names::draw;
use crate::ofx::api::{DrawContextHandle, DrawSuiteV1, PointD, RgbaColour};
use std::ffi::{CStr, c_void};

/// Red, green, blue, opacity.
type Colour = [f32; 4];

/// The drawing backend.
pub(in crate::ofx) enum Painter {
    Suite(&'static DrawSuiteV1, DrawContextHandle),
    OpenGl(OpenGl),
}

impl Painter {
    /// Selects the Draw suite if the host passes a context, else OpenGL if the process has it.
    pub(in crate::ofx) fn new(suite: Option<&'static DrawSuiteV1>, context: Option<*mut c_void>) -> Option<Self> {
        match (suite, context) {
            (Some(suite), Some(context)) => Some(Self::Suite(suite, DrawContextHandle(context))),
            _ => OpenGl::find().map(Self::OpenGl),
        }
    }

    /// Draws a polyline through canonical points.
    pub(in crate::ofx) fn line(&self, points: &[[f64; 2]], colour: Colour, width: f32) {
        match self {
            Self::Suite(suite, context) => suite_line(suite, *context, points, (colour, width)),
            Self::OpenGl(gl) => gl.line(points, colour, width),
        }
    }
}

fn suite_line(suite: &DrawSuiteV1, context: DrawContextHandle, points: &[[f64; 2]], (colour, width): (Colour, f32)) {
    let [r, g, b, a] = colour;
    let colour = RgbaColour { r, g, b, a };
    let points: Vec<PointD> = points.iter().map(|&[x, y]| PointD { x, y }).collect();
    if let Some(set) = suite.set_colour {
        // SAFETY: the host's function with the context of this action; the colour outlives the call.
        let _drawn_in_another_colour = unsafe { set(context, &raw const colour) };
    }
    if let Some(set) = suite.set_line_width {
        // SAFETY: as above.
        let _drawn_thinner = unsafe { set(context, width) };
    }
    if let (Some(paint), Ok(count)) = (suite.draw, i32::try_from(points.len())) {
        // SAFETY: as above; there are `count` points, which outlive the call.
        let _not_drawn = unsafe { paint(context, draw::LINE_STRIP, points.as_ptr(), count) };
    }
}

/// The functions of OpenGL 1 used to draw lines.
#[derive(Clone, Copy)]
pub(in crate::ofx) struct OpenGl {
    begin: unsafe extern "system" fn(u32),
    end: unsafe extern "system" fn(),
    vertex: unsafe extern "system" fn(f64, f64),
    colour: unsafe extern "system" fn(f32, f32, f32, f32),
    width: unsafe extern "system" fn(f32),
}

/// `GL_LINE_STRIP`.
const LINE_STRIP: u32 = 3;

impl OpenGl {
    /// Looks the functions up; `None` if the host's process has no OpenGL. The plugin does not link it.
    fn find() -> Option<Self> {
        let [begin, end, vertex] = [symbol(c"glBegin")?, symbol(c"glEnd")?, symbol(c"glVertex2d")?];
        let [colour, width] = [symbol(c"glColor4f")?, symbol(c"glLineWidth")?];
        Some(Self {
            // SAFETY: this is the function's type in OpenGL 1.
            begin: unsafe { std::mem::transmute::<*mut c_void, unsafe extern "system" fn(u32)>(begin) },
            // SAFETY: as above.
            end: unsafe { std::mem::transmute::<*mut c_void, unsafe extern "system" fn()>(end) },
            // SAFETY: as above.
            vertex: unsafe { std::mem::transmute::<*mut c_void, unsafe extern "system" fn(f64, f64)>(vertex) },
            // SAFETY: as above.
            colour: unsafe {
                std::mem::transmute::<*mut c_void, unsafe extern "system" fn(f32, f32, f32, f32)>(colour)
            },
            // SAFETY: as above.
            width: unsafe { std::mem::transmute::<*mut c_void, unsafe extern "system" fn(f32)>(width) },
        })
    }

    fn line(&self, points: &[[f64; 2]], [r, g, b, a]: Colour, width: f32) {
        // SAFETY: the host made its context current for this action; likewise for the calls below.
        unsafe { (self.width)(width) };
        // SAFETY: as above.
        unsafe { (self.colour)(r, g, b, a) };
        // SAFETY: as above.
        unsafe { (self.begin)(LINE_STRIP) };
        for &[x, y] in points {
            // SAFETY: as above, between begin and end.
            unsafe { (self.vertex)(x, y) };
        }
        // SAFETY: as above.
        unsafe { (self.end)() };
    }
}

#[cfg(unix)]
fn symbol(name: &CStr) -> Option<*mut c_void> {
    unsafe extern "C" {
        fn dlsym(library: *mut c_void, name: *const std::ffi::c_char) -> *mut c_void;
    }
    // `RTLD_DEFAULT`: search the whole process.
    const ANYWHERE: isize = if cfg!(target_vendor = "apple") { -2 } else { 0 };
    // SAFETY: the library is a constant that stands for all loaded ones; the name outlives the call.
    let found = unsafe { dlsym(std::ptr::without_provenance_mut(ANYWHERE as usize), name.as_ptr()) };
    (!found.is_null()).then_some(found)
}

#[cfg(not(unix))]
fn symbol(_name: &CStr) -> Option<*mut c_void> {
    None
}
