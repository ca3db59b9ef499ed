//! Which files of a crate refer to which others, by imports and by paths in their code.
//!
//! This is not a compiler: comments, strings and tests are removed, and every remaining path that begins with a known
//! module is followed, through `use`, to the file that defines its item.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::graph::Edges;

/// A module that has a file.
struct Module {
    file: PathBuf,
    tokens: Vec<String>,
    /// The meaning of imported names, as paths from the root.
    names: BTreeMap<String, Vec<String>>,
    /// Modules imported by `*`.
    globs: Vec<Vec<String>>,
}

/// The modules of a crate, by their path from the root: empty for the root itself.
#[derive(Default)]
pub struct Crate {
    modules: Modules,
}

/// The name of the library in programs.
const LIBRARY: &str = "meshseg";

type Modules = BTreeMap<Vec<String>, Module>;

impl Crate {
    /// Reads the crate whose root is `lib.rs` or `main.rs`.
    pub fn read(root: &Path) -> Crate {
        let mut modules = Crate::default();
        let folder = root.parent().expect("a file");
        modules.add(Vec::new(), root.to_owned(), folder.to_owned());
        modules
    }

    /// The modules at the root, and the root itself if it is that of a program.
    pub fn rooms(&self) -> impl Iterator<Item = String> {
        let rooms = self.modules.keys().filter(|path| path.len() == 1).map(|path| path[0].clone());
        rooms.chain(self.is_program().then(|| "main".to_owned()))
    }

    fn is_program(&self) -> bool {
        self.modules[&[][..]].file.ends_with("main.rs")
    }

    /// Adds a module and those below it, whose files are in `folder`.
    fn add(&mut self, path: Vec<String>, file: PathBuf, folder: PathBuf) {
        let text = fs::read_to_string(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        let tokens = without_tests(tokens(&text));
        for window in tokens.windows(3) {
            if let [word, name, end] = window
                && (word.as_str(), end.as_str()) == ("mod", ";")
            {
                let below = folder.join(name);
                let sibling = folder.join(format!("{name}.rs"));
                let file = if sibling.exists() { sibling } else { below.join("mod.rs") };
                let inside = path.iter().chain([name]).cloned().collect();
                self.add(inside, file, below);
            }
        }
        let (mut names, mut globs) = (BTreeMap::new(), Vec::new());
        let mut at = 0;
        while at < tokens.len() {
            if tokens[at] == "use" {
                let end = at + tokens[at..].iter().position(|token| token == ";").expect("an end");
                for (name, target) in imports(&tokens[at + 1..end]) {
                    let target = absolute(&self.modules, &path, &target);
                    match name {
                        Some(name) => drop(names.insert(name, target)),
                        None => globs.push(target),
                    }
                }
                at = end;
            }
            at += 1;
        }
        self.modules.insert(path, Module { file, tokens, names, globs });
    }

    /// Pairs of a file and a file that defines something it uses. A program uses its library as another crate.
    pub fn edges(&self, library: Option<&Crate>) -> Edges {
        let mut edges = Edges::new();
        for (path, module) in &self.modules {
            for target in self.targets(path, module) {
                let found = match library {
                    Some(library) if target[0] == LIBRARY => library.file_of(&target[1..], 0),
                    _ => self.file_of(&target, 0),
                };
                if let Some(file) = found.filter(|&file| file != module.file) {
                    edges.insert((name(&module.file), name(file)));
                }
            }
        }
        edges
    }

    /// Pairs of a room and a room that it names, or that defines something it uses.
    pub fn named(&self, library: Option<&Crate>) -> Edges {
        let room = |file: &str| {
            let within = file.trim_start_matches("src/").trim_end_matches(".rs");
            within.split('/').next().expect("a part").to_owned()
        };
        let edges = self.edges(library).into_iter();
        let mut named: Edges = edges.map(|(from, to)| (room(&from), room(&to))).collect();
        for (path, module) in &self.modules {
            let from = path.first().cloned().unwrap_or_else(|| room(&name(&module.file)));
            for target in self.targets(path, module) {
                let (of, target) = match library {
                    Some(library) if target[0] == LIBRARY => (library, &target[1..]),
                    _ => (self, &target[..]),
                };
                if let Some(to) =
                    target.first().filter(|&to| of.modules.contains_key(&[to.clone()][..]))
                {
                    named.insert((from.clone(), to.clone()));
                }
            }
        }
        named.retain(|(from, to)| from != to && from != "lib" && to != "lib");
        named
    }

    /// The paths in a module, from the root.
    fn targets(&self, path: &[String], module: &Module) -> Vec<Vec<String>> {
        let mut targets: Vec<Vec<String>> = Vec::new();
        let tokens = &module.tokens;
        let mut at = 0;
        while at < tokens.len() {
            if tokens[at] == "use" {
                let end = at + tokens[at..].iter().position(|token| token == ";").expect("an end");
                // Re-exports count only where they are used.
                if !(at > 0 && (tokens[at - 1] == "pub" || tokens[at - 1] == ")")) {
                    let used = imports(&tokens[at + 1..end]);
                    let used =
                        used.into_iter().map(|(_, target)| absolute(&self.modules, path, &target));
                    // If a module is imported, its items are named later.
                    targets.extend(used.filter(|target| !self.modules.contains_key(target)));
                }
                at = end;
            } else if is_name(&tokens[at]) && (at == 0 || tokens[at - 1] != "::") {
                let mut words = vec![tokens[at].clone()];
                while tokens.get(at + 1).is_some_and(|token| token == "::")
                    && tokens.get(at + 2).is_some_and(|token| is_name(token))
                {
                    words.push(tokens[at + 2].clone());
                    at += 2;
                }
                if words.len() > 1 {
                    targets.push(match module.names.get(&words[0]) {
                        Some(target) => [&target[..], &words[1..]].concat(),
                        None => absolute(&self.modules, path, &words),
                    });
                }
            }
            at += 1;
        }
        targets.retain(|target| !target.is_empty());
        targets
    }

    /// The file that defines an item.
    fn file_of(&self, target: &[String], depth: usize) -> Option<&Path> {
        let known = (0..=target.len()).rev().find(|&n| self.modules.contains_key(&target[..n]))?;
        let module = &self.modules[&target[..known]];
        let Some(name) = target.get(known) else { return Some(&module.file) };
        // Another crate.
        if known == 0 && !module.names.contains_key(name) {
            return None;
        }
        if depth < 20 {
            if let Some(at) = module.names.get(name) {
                return self.file_of(&[&at[..], &target[known + 1..]].concat(), depth + 1);
            }
            for glob in &module.globs {
                let below = [&glob[..], &target[known..]].concat();
                let Some(other) = self.modules.get(glob) else { continue };
                if other.file != module.file && other.defines(name) {
                    return self.file_of(&below, depth + 1);
                }
            }
        }
        Some(&module.file)
    }
}

impl Module {
    fn defines(&self, name: &str) -> bool {
        const KINDS: [&str; 7] = ["fn", "struct", "enum", "trait", "type", "const", "static"];
        self.names.contains_key(name)
            || self.tokens.windows(2).any(|w| KINDS.contains(&w[0].as_str()) && w[1] == name)
    }
}

fn name(file: &Path) -> String {
    file.display().to_string().replace('\\', "/")
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// The path from the root for a path in a module. Names that are not modules of this crate stay as they are.
fn absolute(modules: &Modules, module: &[String], path: &[String]) -> Vec<String> {
    let mut base = module.to_vec();
    let mut rest = path;
    match rest[0].as_str() {
        "crate" => return rest[1..].to_vec(),
        "self" => rest = &rest[1..],
        "super" => {
            while rest.first().is_some_and(|word| word == "super") {
                base.pop();
                rest = &rest[1..];
            }
        }
        first if !modules.contains_key(&[module, &[first.to_owned()]].concat()) => {
            return path.to_vec();
        }
        _ => {}
    }
    [&base[..], rest].concat()
}

/// The imports of a `use`: the local name, or `None` for `*`, and the path.
fn imports(tokens: &[String]) -> Vec<(Option<String>, Vec<String>)> {
    let mut found = Vec::new();
    let (mut path, mut at) = (Vec::new(), 0);
    while at < tokens.len() {
        match tokens[at].as_str() {
            "::" => {}
            "*" => return vec![(None, path)],
            "{" => {
                let mut depth = 0;
                let mut start = at + 1;
                for i in at..tokens.len() {
                    match tokens[i].as_str() {
                        "{" => depth += 1,
                        "}" => depth -= 1,
                        _ => {}
                    }
                    if depth == 1 && tokens[i] == "," || depth == 0 {
                        for (name, below) in imports(&tokens[start..i]) {
                            let mut whole = [&path[..], &below[..]].concat();
                            let mut name = name;
                            if whole.last().is_some_and(|word| word == "self") {
                                whole.pop();
                                name = whole.last().cloned();
                            }
                            found.push((name, whole));
                        }
                        start = i + 1;
                    }
                }
                return found;
            }
            "as" => return vec![(Some(tokens[at + 1].clone()), path)],
            word => path.push(word.to_owned()),
        }
        at += 1;
    }
    if let Some(name) = path.last().cloned() {
        found.push((Some(name), path));
    }
    found
}

/// Words, `::`, and single punctuation characters, without comments; strings are reduced to their quotes.
fn tokens(text: &str) -> Vec<String> {
    let text: Vec<char> = text.chars().collect();
    let starts =
        |at: usize, what: &str| what.chars().enumerate().all(|(i, c)| text.get(at + i) == Some(&c));
    let mut tokens = Vec::new();
    let mut at = 0;
    while at < text.len() {
        let c = text[at];
        let from = at;
        if starts(at, "//") {
            while at < text.len() && text[at] != '\n' {
                at += 1;
            }
        } else if c == '"' {
            at += 1;
            while text[at] != '"' {
                at += if text[at] == '\\' { 2 } else { 1 };
            }
            at += 1;
        } else if c == 'r' && (starts(at, "r\"") || starts(at, "r#")) {
            let hashes = text[at + 1..].iter().take_while(|&&c| c == '#').count();
            let end = format!("\"{}", "#".repeat(hashes));
            at += 2 + hashes;
            while !starts(at, &end) {
                at += 1;
            }
            at += 1 + hashes;
        } else if c == '\'' && (text[at + 1] == '\\' || text.get(at + 2) == Some(&'\'')) {
            at += 2;
            while text[at] != '\'' || text[at - 1] == '\\' && text[at - 2] != '\\' {
                at += 1;
            }
            at += 1;
        } else if c.is_alphanumeric() || c == '_' {
            while at < text.len() && (text[at].is_alphanumeric() || text[at] == '_') {
                at += 1;
            }
            tokens.push(text[from..at].iter().collect());
        } else {
            at += if starts(at, "::") { 2 } else { 1 };
            if !c.is_whitespace() {
                tokens.push(text[from..at].iter().collect());
            }
        }
    }
    tokens
}

/// Removes items that are compiled only for tests.
fn without_tests(tokens: Vec<String>) -> Vec<String> {
    const TEST: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let mut kept = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if !tokens[at..].iter().take(TEST.len()).eq(TEST.iter()) {
            kept.push(tokens[at].clone());
            at += 1;
            continue;
        }
        at += TEST.len();
        let mut depth = 0;
        loop {
            match tokens[at].as_str() {
                "{" | "(" | "[" => depth += 1,
                "}" | ")" | "]" => depth -= 1,
                _ => {}
            }
            at += 1;
            let last = tokens[at - 1].as_str();
            if depth == 0 && (last == ";" || last == "}") {
                break;
            }
        }
    }
    kept
}
