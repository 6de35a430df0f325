//! Blocks of samples, shared out among threads.
//!
//! In: blocks. Out: tasks of about as much work each, the same for every number of threads.

use crate::solve::blocked_weights::Block;

/// Packets times handles of a task. Fixed, so that sums do not depend on the number of threads.
const TASK: usize = 1 << 15;

/// Blocks, or parts of large ones, in tasks of about as much work each.
pub(super) fn tasks(blocks: &[Block]) -> Vec<Vec<Block>> {
    let (mut tasks, mut task, mut work) = (Vec::new(), Vec::new(), 0);
    for block in blocks {
        let most = (TASK / block.handles.len()).max(1);
        for start in block.packets.clone().step_by(most) {
            let part = block.part(start..(start + most).min(block.packets.end));
            work += part.packets.len() * part.handles.len();
            task.push(part);
            if work >= TASK {
                tasks.push(std::mem::take(&mut task));
                work = 0;
            }
        }
    }
    tasks.push(task);
    tasks
}
