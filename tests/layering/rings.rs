//! Rings of files: a file that uses another, which uses it in turn, directly or by way of others.
//!
//! Which file a name is defined in is found by following modules and `use` as the compiler does, as far as the source
//! itself shows it: what a macro makes counts for the file that calls it. A parent that only declares and re-exports its
//! children uses none of them; test-only modules don't count.
//!
//! A file in a module's folder is a part of that module. So it may use what the module's own file defines, and the module
//! may use its parts: that alone is no ring. And who uses a part from outside the folder uses the module.

use super::{
    scopes::{Scope, scan},
    source::module_of,
};
use std::collections::{BTreeMap, VecDeque};

/// A module as its file shows it.
struct Module<'a> {
    file: &'a str,
    inner: &'a Scope,
}

/// The line on which each file first uses each other one.
type Uses<'a> = BTreeMap<&'a str, BTreeMap<&'a str, usize>>;

/// One message for each ring: its files in order, each with the line that names the next one.
pub fn rings(tree: &BTreeMap<String, String>) -> Vec<String> {
    let mut uses = uses(tree);
    let mut found = Vec::new();
    while let Some(ring) = shortest_ring(&uses) {
        let links = ring.iter().zip(ring.iter().cycle().skip(1));
        let links = links.map(|(from, to)| format!("{from}:{} uses {to}", uses[from][to]));
        let links: Vec<String> = links.collect();
        found.push(format!("files in a ring: {}", links.join(", ")));
        for file in &ring {
            uses.remove(file); // so that another ring may be found beside this one
        }
    }
    found
}

/// Which files use which, without `lib.rs`, `main.rs` and test-only files.
fn uses(tree: &BTreeMap<String, String>) -> Uses<'_> {
    let scans: BTreeMap<&str, _> = tree
        .iter()
        .map(|(file, text)| (file.as_str(), scan(file, text)))
        .collect();
    let test_only: Vec<Vec<String>> = scans
        .values()
        .flat_map(|s| s.test_modules.clone())
        .collect();
    let is_test = |module: &[String]| test_only.iter().any(|test| module.starts_with(test));
    let mut modules: BTreeMap<Vec<String>, Module> = BTreeMap::new();
    for (file, scan) in &scans {
        for (path, inner) in &scan.modules {
            modules.insert(path.clone(), Module { file, inner });
        }
    }
    let mut uses = Uses::new();
    for (file, scan) in &scans {
        if ["src/lib.rs", "src/main.rs"].contains(file) || is_test(&module_of(file)) {
            continue;
        }
        for name in &scan.named {
            let Leads::To(used) = defining_file(&modules, &name.module, &name.path, 0) else {
                continue;
            };
            let user = module_of(file);
            let Some((from, _)) = tree.get_key_value(*file) else {
                continue;
            };
            for used in whole_and_part(&modules, used) {
                let module = module_of(used);
                if user.starts_with(&module) || used == "src/lib.rs" || is_test(&module) {
                    continue;
                }
                if let Some((used, _)) = tree.get_key_value(used) {
                    let used_by = uses.entry(from.as_str()).or_default();
                    let first = used_by.entry(used.as_str()).or_insert(name.line);
                    *first = name.line.min(*first);
                }
            }
        }
    }
    uses
}

/// A file and the files of the modules that it is a part of.
fn whole_and_part<'a>(
    modules: &BTreeMap<Vec<String>, Module<'a>>,
    file: &'a str,
) -> impl Iterator<Item = &'a str> {
    let module = module_of(file);
    let ancestors = (1..module.len()).filter_map(|n| modules.get(&module[..n]));
    let ancestors: Vec<&str> = ancestors.map(|module| module.file).collect();
    ancestors.into_iter().chain([file])
}

/// Where a name leads.
enum Leads<'a> {
    /// To an item of that file.
    To(&'a str),
    /// To another crate, or to a module as such, of which nothing is used yet.
    Elsewhere,
    /// Nowhere that the source shows: a macro may have made it.
    Unknown,
}

/// The file that defines what a path names from within a module.
fn defining_file<'a>(
    modules: &BTreeMap<Vec<String>, Module<'a>>,
    module: &[String],
    path: &[String],
    depth: usize,
) -> Leads<'a> {
    let Some((first, rest)) = path.split_first() else {
        return Leads::Elsewhere;
    };
    if depth > 20 {
        return Leads::Elsewhere;
    }
    if first != "crate" {
        return lookup(modules, module, first, rest, depth);
    }
    let mut place = vec![first.clone()];
    for (i, part) in rest.iter().enumerate() {
        place.push(part.clone());
        if !modules.contains_key(&place) {
            place.pop();
            let found = lookup(modules, &place, part, &rest[i + 1..], depth);
            return match (found, modules.get(&place)) {
                (Leads::Unknown, Some(module)) => Leads::To(module.file),
                (found, _) => found,
            };
        }
    }
    Leads::Elsewhere
}

/// The same for `name`, and what follows it where it is a module, as seen in a module.
fn lookup<'a>(
    modules: &BTreeMap<Vec<String>, Module<'a>>,
    module: &[String],
    name: &str,
    rest: &[String],
    depth: usize,
) -> Leads<'a> {
    let Some(here) = modules.get(module) else {
        return Leads::Unknown;
    };
    let followed = |start: &[String], then: &[String]| {
        let path = [start, then].concat();
        defining_file(modules, module, &path, depth + 1)
    };
    let name = &[name.to_string()];
    let child = [module, name].concat();
    if modules.contains_key(&child) {
        return followed(&child, rest);
    }
    if here.inner.items.contains(&name[0]) {
        return Leads::To(here.file);
    }
    if let Some(import) = here
        .inner
        .imports
        .iter()
        .find(|import| import.name == name[0])
    {
        return match followed(&import.path, rest) {
            Leads::Unknown => Leads::Elsewhere, // another crate
            found => found,
        };
    }
    let globs = here.inner.globs.iter().filter(|glob| *glob != module);
    let found = globs.map(|glob| followed(&[glob, &name[..]].concat(), rest));
    let mut known = found.filter(|found| !matches!(found, Leads::Unknown));
    known.next().unwrap_or(Leads::Unknown)
}

/// The ring of fewest files; of several, the first by name.
fn shortest_ring<'a>(uses: &Uses<'a>) -> Option<Vec<&'a str>> {
    let from = uses.keys().filter_map(|start| ring_through(uses, start));
    from.min_by_key(Vec::len)
}

fn ring_through<'a>(uses: &Uses<'a>, start: &'a str) -> Option<Vec<&'a str>> {
    let mut came_from: BTreeMap<&str, &str> = BTreeMap::new();
    let mut waiting = VecDeque::from([start]);
    while let Some(file) = waiting.pop_front() {
        for next in uses
            .get(file)?
            .keys()
            .filter(|next| uses.contains_key(*next))
        {
            if *next == start {
                let mut ring = vec![file];
                while let Some(before) = came_from.get(ring[ring.len() - 1]) {
                    ring.push(before);
                }
                ring.reverse();
                return Some(ring);
            }
            if !came_from.contains_key(next) {
                came_from.insert(next, file);
                waiting.push_back(next);
            }
        }
    }
    None
}
