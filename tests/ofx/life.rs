//! Instances that come and go: nothing is left behind.

use crate::host::profile::{BOOK, MLT};
use crate::host::{Frame, Host, Pixels, Which};
use crate::{SIZE, pulled};

/// Memory of this process, bytes; `None` where the system does not say.
fn memory() -> Option<usize> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    Some(text.split(' ').nth(1)?.parse::<usize>().ok()? * 4096)
}

#[test]
fn a_thousand_instances_leave_nothing_behind() {
    let pixels = Pixels::scenery([32, 18], 4);
    let mut host = Host::start(&BOOK, Which::PinWarp);
    let mut round = |count: usize| {
        for number in 0..count {
            let node = pulled(&mut host, &pixels);
            if number % 50 == 0 {
                host.render(node, Frame::default()).expect("it renders");
            }
            if number % 100 == 7 {
                // A message is left at an instance that ends.
                host.set(node, "shape", 2);
                assert!(host.render(node, Frame::default()).is_err());
            }
            host.destroy(node);
        }
    };
    round(200);
    let before = memory();
    round(1000);
    if let (Some(before), Some(after)) = (before, memory()) {
        let grown = after.saturating_sub(before);
        assert!(grown < 24 << 20, "a thousand instances took {} KiB", grown >> 10);
    }
    host.finish();
}

#[test]
fn plugins_come_back_after_unloading() {
    for _ in 0..20 {
        for which in [Which::PinWarp, Which::StMap] {
            let mut host = Host::start(&MLT, which);
            let node = pulled(&mut host, &Pixels::scenery(SIZE, 4));
            host.render(node, Frame::default()).expect("it renders");
            host.finish();
        }
    }
}
