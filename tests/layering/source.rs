//! The tree as the rules see it: every Rust file with what it declares, defines and names.

use std::fs;
use std::sync::LazyLock;

use patrold_test_support::workspace_root;
use proc_macro2::{Delimiter, TokenStream, TokenTree};

const KINDS: [&str; 8] = [
    "mod", "struct", "enum", "trait", "type", "fn", "const", "static",
];

/// Paths of the project's files.
pub(crate) static FILES: LazyLock<Vec<String>> = LazyLock::new(|| files(""));
/// Its Rust files.
pub(crate) static TREE: LazyLock<Vec<Source>> = LazyLock::new(|| {
    let rust = FILES.iter().filter(|path| path.ends_with(".rs"));
    mark_tests(rust.map(|path| Source::new(path, &read(path))).collect())
});

#[derive(Default)]
pub(crate) struct Source {
    pub path: String,
    pub text: String,
    /// `engine/src/novelty` of `engine/src/novelty/mod.rs`.
    pub module: String,
    /// What it defines outside functions.
    pub items: Vec<Item>,
    /// Imports, and paths of two or more names.
    pub names: Vec<Name>,
    /// It has a function outside its tests.
    pub works: bool,
}

pub(crate) struct Item {
    /// One of [`KINDS`].
    pub kind: String,
    pub name: String,
    pub scope: Scope,
}

pub(crate) struct Name {
    /// As written: `super::detect::run`.
    pub path: String,
    /// Where that is in this crate: `engine/src/novelty/detect/run`.
    pub place: String,
    /// What an import calls it.
    pub alias: String,
    pub scope: Scope,
}

#[derive(Clone, Copy, Default)]
pub(crate) struct Scope {
    pub test: bool,
    pub public: bool,
    pub import: bool,
    nested: bool,
    inline_module: bool,
}

impl Source {
    pub(crate) fn new(path: &str, text: &str) -> Self {
        let ends = [".rs", "/mod", "/lib", "/main"];
        let module = ends.iter().fold(path, |m, end| m.trim_end_matches(end));
        let tokens = text.parse().unwrap_or_else(|e| panic!("{path}: {e}"));
        let mut source = Self::default();
        [source.path, source.text, source.module] = [path, text, module].map(str::to_owned);
        source.read(tokens, "", Scope::default());
        source
    }

    /// Folder of its crate's sources; none for `tests/`, `benches/` and `fuzz/`.
    pub(crate) fn root(&self) -> Option<&str> {
        let end = self.path.find("src/")? + "src".len();
        (!self.path.starts_with("tests/")).then(|| &self.path[..end])
    }

    pub(crate) fn is_front(&self) -> bool {
        let tests = self.path.contains("/tests/");
        !tests && (self.path.ends_with("/mod.rs") || self.path.ends_with("/lib.rs"))
    }

    /// Notes what `tokens` define and name. Their paths begin with `prefix`, as in `prefix::{a, b}`.
    fn read(&mut self, tokens: TokenStream, prefix: &str, outer: Scope) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let word = |at: usize, n| match at.checked_add_signed(n).and_then(|at| tokens.get(at)) {
            None | Some(TokenTree::Group(_)) => String::new(),
            Some(token) => token.to_string(),
        };
        let (mut here, mut path) = (outer, String::new());
        for (at, token) in tokens.iter().enumerate() {
            let [before, now, next, then] = [-1, 0, 1, 2].map(|n| word(at, n));
            let joined = before == ":" && word(at, -2) == ":";
            match (token, now.as_str()) {
                (TokenTree::Group(group), _) if joined => {
                    self.read(group.stream(), &format!("{path}::"), here);
                }
                (TokenTree::Group(group), _) => {
                    let is_test = || group.to_string().replace(' ', "") == "[cfg(test)]";
                    here.test |= before == "#" && is_test();
                    let mut inside = here;
                    inside.public = false;
                    inside.nested = true;
                    inside.import = before == "use";
                    inside.inline_module |= word(at, -2) == "mod";
                    self.read(group.stream(), "", inside);
                    if group.delimiter() == Delimiter::Brace {
                        here = outer;
                    }
                }
                (_, ";") => here = outer,
                (_, "use") => here.import = true,
                (_, "pub") => here.public = true,
                (_, "*") if joined => self.name(&path, "", here),
                (TokenTree::Ident(_), _) if now != "as" && !(here.import && before == "as") => {
                    let start: String = if joined { path + "::" } else { prefix.into() };
                    path = start + &now;
                    if next != ":" || then != ":" || word(at, 3) == "<" {
                        self.name(&path, if next == "as" { &then } else { "" }, here);
                    }
                    self.works |= now == "fn" && !here.test;
                    let declared = now != "mod" || then == ";";
                    if KINDS.contains(&now.as_str()) && declared && !here.nested {
                        let (kind, name, scope) = (now, next, here);
                        self.items.push(Item { kind, name, scope });
                    }
                }
                _ => {}
            }
        }
    }

    fn name(&mut self, path: &str, alias: &str, scope: Scope) {
        let mut place: Vec<&str> = self.module.split('/').collect();
        for (n, part) in path.split("::").enumerate() {
            match part {
                "self" => {}
                "super" if n == 0 && scope.inline_module => {} // its file
                "super" => drop(place.pop()),
                "crate" => place = self.root().unwrap_or_default().split('/').collect(),
                _ => place.push(part),
            }
        }
        let last = place.last().copied().unwrap_or_default();
        let alias = if alias.is_empty() { last } else { alias }.to_owned();
        let (path, place) = (path.to_owned(), place.join("/"));
        if path.contains("::") || scope.import {
            self.names.push(Name {
                path,
                place,
                alias,
                scope,
            });
        }
    }
}

/// Marks the files that only tests declare.
pub(crate) fn mark_tests(mut files: Vec<Source>) -> Vec<Source> {
    let mut tests = Vec::new();
    for file in &files {
        let of_tests = |item: &&Item| item.kind == "mod" && item.scope.test;
        let modules = file.items.iter().filter(of_tests);
        tests.extend(modules.map(|module| format!("{}/{}/", file.module, module.name)));
    }
    for file in &mut files {
        let module = format!("{}/", file.module);
        if tests.iter().any(|test| module.starts_with(test)) {
            file.items.clear();
            file.names.iter_mut().for_each(|n| n.scope.test = true);
        }
    }
    files
}

fn files(folder: &str) -> Vec<String> {
    let entries = fs::read_dir(workspace_root().join(folder)).expect("a folder");
    let mut found = Vec::new();
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if !entry.path().is_dir() {
            found.push(format!("{folder}{name}"));
        } else if name != "target" && !name.starts_with('.') {
            found.extend(files(&format!("{folder}{name}/")));
        }
    }
    found
}

/// The text of a file of the project.
pub(crate) fn read(path: &str) -> String {
    fs::read_to_string(workspace_root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}
