//! Divides blocks of samples into tasks for several threads.
//!
//! In: blocks. Out: tasks with about equal work, the same for any number of threads.

use crate::solve::blocked_weights::Block;

/// Work of a task, as packets times handles. It is fixed, so that sums do not depend on the number of threads.
const TASK: usize = 1 << 15;

/// Groups blocks into tasks with about equal work; large blocks are split.
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
