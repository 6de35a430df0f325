//! The memory budget: what does not fit is refused and told, and what fits goes on.

use crate::host::api::Status;
use crate::host::api::names::MESSAGE_ERROR;
use crate::host::profile::BOOK;
use crate::host::{Frame, Host, Node, Pixels, Which};
use crate::{SIZE, pulled};
use pinwarp::image::{Compression, FrameMetadata, Storage};
use pinwarp::space::PixelRect;
use std::process::Command;

/// The variable that holds the plugin's limit.
const VARIABLE: &str = "PINWARP_MAX_MEMORY";

/// A picture that takes more than two megabytes.
const LARGE: [i32; 2] = [640, 360];

/// Runs `work` in a process of its own, the test of that name once more, with that limit: the budget is the process's.
fn limited(limit: &str, name: &str, work: fn()) {
    if std::env::var(VARIABLE).is_ok_and(|set| set == limit) {
        return work();
    }
    let mut child = Command::new(std::env::current_exe().expect("it runs"));
    let ran = child.args(["--exact", name, "--nocapture"]).env(VARIABLE, limit).output().expect("it starts");
    let words = [ran.stdout, ran.stderr].map(|words| String::from_utf8_lossy(&words).into_owned());
    assert!(ran.status.success() && words[0].contains("1 passed"), "{}\n{}", words[0], words[1]);
}

/// The one message that the host shows, an error that stays.
fn error(host: &Host) -> String {
    let said = host.said();
    assert!(said.len() == 1 && said[0].lasts && said[0].kind.as_bytes() == MESSAGE_ERROR.to_bytes(), "{said:?}");
    said[0].text.clone()
}

/// Renders a picture of that size: the status, and what is told.
fn rendered(host: &Host, node: Node, size: [i32; 2]) -> Result<(), String> {
    host.through(node, &Pixels::scenery(size, 4));
    match host.render(node, Frame::default()) {
        Ok(_) => {
            assert!(host.said().is_empty(), "what was wrong is over: {:?}", host.said());
            Ok(())
        }
        Err(status) => {
            assert_eq!(status, Status::ERR_MEMORY, "{:?}", host.said());
            Err(error(host))
        }
    }
}

#[test]
fn pictures_and_maps_that_do_not_fit_are_refused_and_others_go_on() {
    limited("2M", "memory::pictures_and_maps_that_do_not_fit_are_refused_and_others_go_on", || {
        for which in [Which::PinWarp, Which::StMap] {
            let mut host = Host::start(&BOOK, which);
            let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
            for _again in 0..2 {
                let told = rendered(&host, node, LARGE).expect_err("it does not fit");
                for part in ["640 x 360 pixels", " MB of memory", "2 MB may be used", VARIABLE, "proxy"] {
                    assert!(told.contains(part), "{part} is not in: {told}");
                }
                rendered(&host, node, SIZE).expect("it fits");
            }
            host.finish();
        }
    });
}

#[test]
fn solves_that_do_not_fit_are_refused_and_others_go_on() {
    limited("20M", "memory::solves_that_do_not_fit_are_refused_and_others_go_on", || {
        let mut host = Host::start(&BOOK, Which::PinWarp);
        let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
        let (splines, bernstein) = (0, 1);
        for (basis, count, fits) in [(bernstein, 40, false), (splines, 10, true), (splines, 64, false)] {
            host.set(node, "basis", basis);
            ["columns", "rows"].iter().for_each(|id| host.set(node, id, count));
            match rendered(&host, node, SIZE) {
                Ok(()) => assert!(fits, "{count}"),
                Err(told) => assert!(!fits && told.contains(&format!("{count} x {count} handles")), "{told}"),
            }
            if !fits {
                // Regions need the same solve.
                assert_eq!(host.region(node, [1.0, 1.0]), None);
            }
        }
        host.finish();
    });
}

#[test]
fn files_that_do_not_fit_are_neither_read_nor_written() {
    limited("2M", "memory::files_that_do_not_fit_are_neither_read_nor_written", || {
        let folder = tempfile::tempdir().expect("a folder");
        let text = |name: &str| folder.path().join(name).to_str().expect("plain letters").to_owned();
        let mut host = Host::start(&BOOK, Which::PinWarp);
        let node = pulled(&mut host, &Pixels::scenery(LARGE, 4));
        host.set(node, "stmapFolder", text("maps").as_str());
        assert_eq!(host.press(node, "writeStmaps"), Status::ERR_MEMORY);
        assert!(error(&host).contains("640 x 360"), "{:?}", host.said());
        assert!(!folder.path().join("maps").exists());

        let window = PixelRect { x: 0, y: 0, width: 1000, height: 1000 };
        let channels = ["R", "G", "B", "A"].map(|name| (name, Storage::Half));
        let frame = pinwarp::image::Frame::blank(window, window, &channels);
        let metadata = FrameMetadata { frame: 0, frames_per_second: 24.0, device: "CPU".into(), ..Default::default() };
        let drawing = folder.path().join("drawing.exr");
        pinwarp::image::write_exr(&drawing, &frame, &metadata, Compression::Zip).expect("written");
        let shot = "version = 1\nimage = \"drawing.exr\"\nframes = { first = 0, last = 0 }\nsize = [160, 90]\n";
        std::fs::write(folder.path().join("shot.toml"), shot).expect("written");
        host.set(node, "shape", 2);
        host.set(node, "shotFile", text("shot.toml").as_str());
        host.press(node, "shape");
        let told = rendered(&host, node, SIZE).expect_err("the drawing does not fit");
        assert!(told.contains("drawing.exr needs about"), "{told}");
        host.set(node, "shape", 0);
        rendered(&host, node, SIZE).expect("it fits");
        host.finish();
    });
}

#[test]
fn an_invalid_limit_is_reported() {
    limited("lots", "memory::an_invalid_limit_is_reported", || {
        let mut host = Host::start(&BOOK, Which::PinWarp);
        let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
        assert_eq!(host.render(node, Frame::default()).err(), Some(Status::FAILED));
        let told = error(&host);
        assert!(told.contains(VARIABLE) && told.contains("lots") && told.contains("8G, 512M, 50%"), "{told}");
        host.finish();
    });
}
