//! Which file of the crate imports which, and the circles among them.
//!
//! In: paths and texts of source files. Out: a graph of files. A path is followed through re-exports to the file that defines
//! what it names, so a `mod.rs` that only re-exports is part of no circle. Test modules are left out.

use std::collections::{BTreeMap, BTreeSet};

/// Steps through re-exports, at most.
const MAX_REEXPORTS: usize = 8;

/// The module path of a file: `src/solve/energy/mod.rs` to `[solve, energy]`.
type Module = Vec<String>;

/// Files and the files they import.
pub(crate) struct Imports {
    files: BTreeMap<Module, String>,
    /// What modules re-export: module and name to the path it stands for.
    reexports: BTreeMap<(Module, String), (Module, Vec<String>)>,
    edges: BTreeMap<String, BTreeSet<String>>,
}

impl Imports {
    /// Reads the imports of files, each a path from the root and its text.
    pub(crate) fn of(sources: &[(String, String)]) -> Self {
        let files = sources.iter().map(|(file, _)| (module_of(file), file.clone())).collect();
        let mut imports = Self { files, reexports: BTreeMap::new(), edges: BTreeMap::new() };
        let texts: Vec<(Module, String)> = sources.iter().map(|(file, text)| (module_of(file), code(text))).collect();
        for (module, text) in &texts {
            for path in uses(text).filter(|(is_public, _)| *is_public).flat_map(|(_, tree)| flattened(&tree)) {
                let Some((base, rest)) = imports.absolute(&path, module) else { continue };
                let Some(name) = rest.last().cloned() else { continue };
                imports.reexports.insert((module.clone(), name), (base, rest));
            }
        }
        for (module, text) in &texts {
            let used = uses(text).filter(|(is_public, _)| !is_public).flat_map(|(_, tree)| flattened(&tree));
            let paths: Vec<String> = used.chain(inline_paths(text)).collect();
            let file = imports.files[module].clone();
            let targets = paths.iter().filter_map(|path| imports.target(path, module)).filter(|target| *target != file);
            let targets: BTreeSet<String> = targets.collect();
            imports.edges.insert(file, targets);
        }
        imports
    }

    /// Module and rest of a path; `None` for paths into other crates.
    fn absolute(&self, path: &str, module: &Module) -> Option<(Module, Vec<String>)> {
        let mut parts: Vec<String> = path.split("::").map(|part| part.trim().to_owned()).collect();
        let mut base = module.clone();
        match parts[0].as_str() {
            "crate" => base.clear(),
            "self" => {}
            "super" => {
                while parts.len() > 1 && parts[1] == "super" {
                    base.pop();
                    parts.remove(0);
                }
                base.pop();
            }
            first if self.files.contains_key(&joined(module, first)) => return Some((base, parts)),
            _ => return None,
        }
        parts.remove(0);
        Some((base, parts))
    }

    /// The file that defines what a path names.
    fn target(&self, path: &str, module: &Module) -> Option<String> {
        let (mut base, mut rest) = self.absolute(path, module)?;
        for _ in 0..MAX_REEXPORTS {
            while rest.first().is_some_and(|first| self.files.contains_key(&joined(&base, first))) {
                base.push(rest.remove(0));
            }
            let Some(first) = rest.first() else { break };
            let Some((next, path)) = self.reexports.get(&(base.clone(), first.clone())) else { break };
            (base, rest) = (next.clone(), path.clone());
        }
        self.files.get(&base).cloned()
    }

    /// Sets of files that import each other, directly or through others.
    pub(crate) fn circles(&self) -> Vec<Vec<String>> {
        let reached: BTreeMap<&String, BTreeSet<String>> =
            self.edges.keys().map(|file| (file, self.reachable(file))).collect();
        let mut circles: BTreeSet<Vec<String>> = BTreeSet::new();
        for (file, reachable) in &reached {
            let circle: Vec<String> =
                reachable.iter().filter(|other| reached[other].contains(*file)).cloned().collect();
            if circle.len() > 1 {
                circles.insert(circle);
            }
        }
        circles.into_iter().collect()
    }

    fn reachable(&self, from: &String) -> BTreeSet<String> {
        let mut found = BTreeSet::new();
        let mut open: Vec<&String> = self.edges[from].iter().collect();
        while let Some(file) = open.pop() {
            if found.insert(file.clone()) {
                open.extend(&self.edges[file]);
            }
        }
        found
    }
}

fn joined(module: &Module, name: &str) -> Module {
    module.iter().cloned().chain([name.to_owned()]).collect()
}

fn module_of(file: &str) -> Module {
    let path = file.trim_start_matches("src/").trim_end_matches(".rs").trim_end_matches("/mod");
    if path == "lib" { Vec::new() } else { path.split('/').map(str::to_owned).collect() }
}

/// The text before its tests, without comments.
fn code(text: &str) -> String {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    code.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// The trees of all use declarations, and whether they re-export.
fn uses(text: &str) -> impl Iterator<Item = (bool, String)> {
    text.split(';').filter_map(|statement| {
        let at = statement.rfind("use ")?;
        let before = statement[..at].lines().last().unwrap_or_default().trim();
        let is_public = before.starts_with("pub");
        (before.is_empty() || is_public).then(|| (is_public, statement[at + 4..].replace('\n', " ")))
    })
}

/// All paths of a use tree.
fn flattened(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some((head, rest)) = tree.split_once('{') else {
        return vec![tree.split(" as ").next().unwrap_or(tree).replace(' ', "")];
    };
    let inner = rest.rsplit_once('}').map_or(rest, |(inner, _)| inner);
    let mut items = vec![String::new()];
    let mut depth = 0;
    for letter in inner.chars() {
        depth += i32::from(letter == '{') - i32::from(letter == '}');
        if letter == ',' && depth == 0 {
            items.push(String::new());
        } else {
            items.last_mut().expect("never empty").push(letter);
        }
    }
    items.retain(|item| !item.trim().is_empty());
    let paths = items.iter().flat_map(|item| flattened(item));
    paths.map(|path| format!("{}{path}", head.trim()).trim_end_matches("::self").to_owned()).collect()
}

/// Paths that stand in the code itself: `super::a::f`, not those of visibilities.
fn inline_paths(text: &str) -> impl Iterator<Item = String> {
    let starts = ["super::", "self::", "crate::"].into_iter().flat_map(|start| text.match_indices(start));
    starts.filter_map(|(at, _)| {
        let before = text[..at].trim_end();
        let is_inner = text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':');
        let is_other = before.ends_with("use") || before.ends_with("(in") || before.ends_with("pub(");
        let path: String = text[at..].chars().take_while(|c| c.is_alphanumeric() || *c == '_' || *c == ':').collect();
        (!is_inner && !is_other).then(|| path.trim_end_matches(':').to_owned())
    })
}
