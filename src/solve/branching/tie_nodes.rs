//! Nodes of the graph in which ties are sought.
//!
//! In: the parts of cells around the support of a handle, with their roles. Out: the node of each triangle: one node for all triangles
//! on which a copy acts, one for every other triangle beside the support. Nodes are looked up when a link needs them, because most
//! triangles are connected inside their cell alone.

use super::cell_parts::CellParts;
use std::ops::Range;

/// Stands for a triangle that was not looked up.
const UNKNOWN: u32 = u32::MAX;

/// Stands for the node of a triangle that has none.
const NONE: u32 = u32::MAX - 1;

/// How a part takes part in the ties of a handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// It is not connected with several copies when the support grows by one.
    None,
    /// It lies in the support, in the piece of the copy with this node.
    Copy(u32),
    /// It lies beside the support.
    Beside,
}

/// The nodes of triangles.
pub(super) struct TieNodes<'a, const D: usize> {
    parts: &'a CellParts<D>,
    /// The role of each part, #parts.
    roles: Vec<Role>,
    /// The node of each triangle, #triangles.
    of_triangles: Vec<u32>,
    /// The triangles that were looked up.
    known: Vec<u32>,
    count: u32,
}

impl<'a, const D: usize> TieNodes<'a, D> {
    pub(super) fn new(parts: &'a CellParts<D>) -> Self {
        Self {
            parts,
            roles: vec![Role::None; parts.len()],
            of_triangles: vec![UNKNOWN; parts.triangle_count()],
            known: Vec::new(),
            count: 0,
        }
    }

    pub(super) fn set_role(&mut self, part: u32, role: Role) {
        self.roles[part as usize] = role;
    }

    /// Whether any of these parts has a role.
    pub(super) fn has_any(&self, parts: Range<usize>) -> bool {
        self.roles[parts].iter().any(|role| *role != Role::None)
    }

    /// Reserves the first nodes for copies.
    pub(super) fn start_with(&mut self, copies: usize) {
        self.count = copies as u32;
    }

    /// Number of nodes.
    pub(super) const fn count(&self) -> usize {
        self.count as usize
    }

    /// The nodes of two triangles; `None` if they have the same one, or one of them has none.
    pub(super) fn pair(&mut self, [one, other]: [u32; 2]) -> Option<[u32; 2]> {
        let pair = [self.node(one), self.node(other)];
        (pair[0] != pair[1] && pair[0] != NONE && pair[1] != NONE).then_some(pair)
    }

    fn node(&mut self, triangle: u32) -> u32 {
        match self.of_triangles.get(triangle as usize) {
            None => NONE,
            Some(&UNKNOWN) => self.look_up(triangle),
            Some(&node) => node,
        }
    }

    fn look_up(&mut self, triangle: u32) -> u32 {
        let parts = self.parts.parts_of(triangle as usize).unwrap_or_default();
        let mut node = NONE;
        for &part in parts {
            match self.roles[part as usize] {
                Role::None => (),
                Role::Copy(copy) => node = copy,
                Role::Beside if node == NONE => {
                    node = self.count;
                    self.count += 1;
                }
                Role::Beside => (),
            }
        }
        self.of_triangles[triangle as usize] = node;
        self.known.push(triangle);
        node
    }

    /// Forgets the roles of these parts, and all nodes.
    pub(super) fn clear(&mut self, parts: &[u32]) {
        parts.iter().for_each(|&part| self.roles[part as usize] = Role::None);
        self.known.drain(..).for_each(|triangle| self.of_triangles[triangle as usize] = UNKNOWN);
    }
}
