//! Time of the plugin's render actions, without the time of the host itself. 1080p RGBA, 10 x 10 handles, 8 pins, whole
//! frames into the host's memory.
#![expect(unsafe_code, reason = "the tests' host of a C API")]

#[allow(dead_code, unused_imports, reason = "tests use the rest of it")]
#[path = "../tests/ofx/host/mod.rs"]
mod host;

use criterion::{Criterion, criterion_group, criterion_main};
use host::api::names::image;
use host::profile::NATRON;
use host::{Depth, Frame, Host, Node, Pixels, Which, feed};
use std::time::Duration;

fn pull(host: &Host, node: Node, nudge: f64) {
    for number in 0..8 {
        let rest = [330.0 + 400.0 * f64::from(number % 4), 330.0 + 430.0 * f64::from(number / 4)];
        let by = 32.0 * (f64::from(number * 7 % 5) - 2.0);
        host.pin(node, number as usize + 1, rest, [rest[0] + by + nudge, rest[1] + 0.5 * by]);
    }
}

fn renders(criterion: &mut Criterion) {
    let mut host = Host::start(&NATRON, Which::PinWarp);
    let node = host.node();
    let pixels = Pixels::scenery([1920, 1080], 4);
    let choose = |filter: &str| {
        let place = ["Cubic", "EWA"].iter().position(|name| *name == filter).expect("a filter of the plugin");
        host.set(node, "filter", place as i32);
    };
    choose("Cubic");
    for depth in [Depth::Float, Depth::Half, Depth::Byte] {
        for (clip, shown) in [(image::SOURCE_CLIP, Some(pixels.clone())), (image::OUTPUT_CLIP, None)] {
            host.feed_as(node, clip, feed(shown, pixels.bounds, 4).with_depth(depth));
        }
        pull(&host, node, 0.0);
        let renderer = host.renderer();
        criterion.bench_function(&format!("ofx/still/cubic/{depth:?}"), |bench| {
            bench.iter_custom(|count| (0..count).map(|_| renderer.timed(node, Frame::default())).sum());
        });
    }
    host.through(node, &pixels);
    choose("EWA");
    criterion.bench_function("ofx/still/ewa/Float", |bench| {
        bench.iter_custom(|count| (0..count).map(|_| host.renderer().timed(node, Frame::default())).sum());
    });
    choose("Cubic");
    let mut nudge = 0.0;
    criterion.bench_function("ofx/dragged/cubic/Float", |bench| {
        bench.iter_custom(|count| {
            let drag = |_| -> Duration {
                nudge += 0.1;
                pull(&host, node, nudge);
                host.renderer().timed(node, Frame::default())
            };
            (0..count).map(drag).sum()
        });
    });
    host.finish();
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = renders }
criterion_main!(benches);
