//! Who is meant by a name: WGSL's scopes over tokens.
//!
//! naga keeps no spans of type references, parameters and called names, so renaming needs this pass. It follows
//! the specification's "Declaration and Scope": module-scope names are visible everywhere, a local from the end
//! of its declaration statement to the end of its block, a `for` initializer in the whole loop, a parameter in
//! the body. It never judges: on text that isn't WGSL its answers mean nothing and naga reports the error.

mod ways;

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use crate::tokens::{Token, TokenKind, Tokens, tokenize};

/// What a token stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// A number, punctuation, a keyword, a member or an attribute's name.
    Other,
    /// Declares or names something the file itself declares at module scope.
    Global,
    /// Declares or names a local or a parameter: the index of the declaring token.
    Local(usize),
    /// Declared neither in the file nor locally: WGSL's or the prelude's.
    Predeclared,
}

/// Which keyword opened a module-scope declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GlobalKind {
    Function,
    Struct,
    Alias,
    Const,
    Override,
    Var,
    ConstAssert,
    Directive,
}

/// A module-scope declaration.
#[derive(Clone, Debug)]
pub(crate) struct GlobalDecl {
    pub(crate) kind: GlobalKind,
    /// Token of the keyword.
    pub(crate) keyword: usize,
    /// Token of the name; none for assertions, directives and broken text.
    pub(crate) name: Option<usize>,
    /// All its tokens, attributes and final `}` or `;` included.
    pub(crate) tokens: Range<usize>,
}

/// A parameter of a function.
#[derive(Clone, Debug)]
pub(crate) struct ParamDecl {
    pub(crate) name: usize,
    /// Tokens of the type.
    pub(crate) ty: Range<usize>,
}

/// A function's parts, by token index.
#[derive(Clone, Debug)]
pub(crate) struct FunctionDecl {
    /// Token `fn`.
    pub(crate) keyword: usize,
    pub(crate) name: usize,
    pub(crate) params: Vec<ParamDecl>,
    /// Tokens of the return type; empty where there is none.
    pub(crate) result: Range<usize>,
    /// `{` and `}` of the body.
    pub(crate) body: Range<usize>,
    /// See [`Outline::shadows_its_result`].
    shadows_result: bool,
}

/// A loop.
#[derive(Clone, Debug)]
pub(crate) struct LoopDecl {
    /// Token of `for`, `while` or `loop`.
    pub(crate) keyword: usize,
    /// Tokens `{` to `}` of the body, both included.
    pub(crate) body: Range<usize>,
    /// Index into [`Outline::functions`].
    pub(crate) function: usize,
    /// Whether it lies in a `continuing` block, where `return` is not allowed.
    pub(crate) in_continuing: bool,
}

/// Tokens of a file with the role of each, and the declarations found on the way.
#[derive(Debug)]
pub(crate) struct Outline<'a> {
    pub(crate) text: &'a str,
    pub(crate) tokens: Tokens<'a>,
    pub(crate) roles: Vec<Role>,
    pub(crate) globals: Vec<GlobalDecl>,
    pub(crate) functions: Vec<FunctionDecl>,
    pub(crate) loops: Vec<LoopDecl>,
    function_by_name: HashMap<&'a str, usize>,
}

impl<'a> Outline<'a> {
    /// Analyses a file.
    pub(crate) fn new(text: &'a str) -> Self {
        let tokens = tokenize(text);
        let globals = find_globals(&tokens.tokens);
        let mut names = HashMap::new();
        for name in globals.iter().filter_map(|global| global.name) {
            names.insert(tokens.tokens[name].text, name);
        }
        let mut outline = Self {
            text,
            roles: vec![Role::Other; tokens.tokens.len()],
            tokens,
            globals,
            functions: Vec::new(),
            loops: Vec::new(),
            function_by_name: HashMap::new(),
        };
        for global in outline.globals.clone() {
            Walker {
                outline: &mut outline,
                globals: &names,
                scopes: Vec::new(),
                locals: HashMap::new(),
            }
            .declaration(&global);
        }
        outline
    }

    /// The text of token `at`; empty beyond the end.
    pub(crate) fn word(&self, at: usize) -> &'a str {
        self.tokens.tokens.get(at).map_or("", |token| token.text)
    }

    /// Byte range of token `at`.
    pub(crate) fn span(&self, at: usize) -> Range<usize> {
        self.tokens
            .tokens
            .get(at)
            .map_or(self.text.len()..self.text.len(), Token::span)
    }

    /// Byte range from the first to the last of these tokens.
    pub(crate) fn span_of(&self, tokens: &Range<usize>) -> Range<usize> {
        if tokens.is_empty() {
            return self.span(tokens.start);
        }
        self.span(tokens.start).start..self.span(tokens.end - 1).end
    }

    /// The function of that name.
    pub(crate) fn function(&self, name: &str) -> Option<&FunctionDecl> {
        self.functions
            .iter()
            .find(|function| self.word(function.name) == name)
    }

    /// Functions of the file that these tokens name, once for each time.
    pub(crate) fn calls(&self, tokens: Range<usize>) -> Vec<usize> {
        tokens
            .filter(|&at| self.roles[at] == Role::Global)
            .filter_map(|at| self.function_by_name.get(self.word(at)).copied())
            .collect()
    }

    /// Whether a parameter or local anywhere in the function has this name.
    pub(crate) fn is_shadowed(&self, function: &FunctionDecl, name: &str) -> bool {
        let declares = |at: usize| self.roles[at] == Role::Local(at) && self.word(at) == name;
        function.params.iter().any(|param| declares(param.name))
            || function.body.clone().any(declares)
    }

    /// Whether an expression in the function could mean something else by its result type: a local has a name of it.
    pub(crate) fn shadows_its_result(&self, function: &FunctionDecl) -> bool {
        function.shadows_result
    }

    /// Works that out: once for each function, for all loops in it ask.
    fn hides_result(&self, function: &FunctionDecl) -> bool {
        if function.result.is_empty() {
            return false;
        }
        let names: HashSet<&str> = function.result.clone().map(|at| self.word(at)).collect();
        let declares =
            |at: usize| self.roles[at] == Role::Local(at) && names.contains(self.word(at));
        function.params.iter().any(|param| declares(param.name))
            || function.body.clone().any(declares)
    }

    /// The token that closes the bracket opened at `open`, or the last token.
    pub(crate) fn closing(&self, open: usize) -> usize {
        matching(&self.tokens.tokens, open)
    }
}

/// Index of the bracket that closes the one at `open`; the last token where none does.
fn matching(tokens: &[Token<'_>], open: usize) -> usize {
    let mut depth = 0usize;
    for (at, token) in tokens.iter().enumerate().skip(open) {
        match token.text {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return at;
                }
            }
            _ => {}
        }
    }
    tokens.len().saturating_sub(1)
}

/// Index behind the template list that may begin at `at` (`<...>`), else `at`.
pub(crate) fn skip_template(tokens: &[Token<'_>], at: usize) -> usize {
    if tokens.get(at).map(|token| token.text) != Some("<") {
        return at;
    }
    let mut depth = 0usize;
    for (index, token) in tokens.iter().enumerate().skip(at) {
        match token.text {
            "<" => depth += 1,
            ">" => {
                depth -= 1;
                if depth == 0 {
                    return index + 1;
                }
            }
            ";" | "{" | "}" => return index,
            _ => {}
        }
    }
    tokens.len()
}

fn find_globals(tokens: &[Token<'_>]) -> Vec<GlobalDecl> {
    let mut globals = Vec::new();
    let mut at = 0;
    let mut start = 0; // where the declaration begins: its attributes
    while at < tokens.len() {
        let kind = match tokens[at].text {
            "fn" => GlobalKind::Function,
            "struct" => GlobalKind::Struct,
            "alias" => GlobalKind::Alias,
            "const" => GlobalKind::Const,
            "override" => GlobalKind::Override,
            "var" => GlobalKind::Var,
            "const_assert" => GlobalKind::ConstAssert,
            "enable" | "requires" => GlobalKind::Directive,
            "diagnostic" if at == 0 || tokens[at - 1].text != "@" => GlobalKind::Directive,
            "(" | "[" | "{" => {
                at = matching(tokens, at) + 1;
                continue;
            }
            ";" | "}" => {
                at += 1;
                start = at;
                continue;
            }
            _ => {
                at += 1;
                continue;
            }
        };
        let keyword = at;
        let name_at = if kind == GlobalKind::Var {
            skip_template(tokens, at + 1)
        } else {
            at + 1
        };
        let named = !matches!(kind, GlobalKind::ConstAssert | GlobalKind::Directive);
        let name = tokens
            .get(name_at)
            .filter(|token| named && token.kind == TokenKind::Word)
            .map(|_| name_at);
        let braces = matches!(kind, GlobalKind::Function | GlobalKind::Struct);
        let mut end = at + 1;
        while let Some(token) = tokens.get(end) {
            match token.text {
                "{" => {
                    end = matching(tokens, end) + 1;
                    if braces {
                        break;
                    }
                }
                "(" | "[" => end = matching(tokens, end) + 1,
                ";" => {
                    end += 1;
                    break;
                }
                // A lost closing brace: the next declaration begins here.
                "fn" | "struct" | "alias" => break,
                _ => end += 1,
            }
        }
        let end = end.min(tokens.len());
        globals.push(GlobalDecl {
            kind,
            keyword,
            name,
            tokens: start..end,
        });
        at = end;
        start = end;
    }
    globals
}

struct Scope<'a> {
    /// What it declares.
    names: Vec<&'a str>,
    /// Holds a `for` loop's header: ends together with the loop's body.
    is_for: bool,
    continuing: bool,
    /// Index into `loops` of the loop whose body this is.
    body_of: Option<usize>,
}

struct Walker<'o, 'a> {
    outline: &'o mut Outline<'a>,
    globals: &'o HashMap<&'a str, usize>,
    scopes: Vec<Scope<'a>>,
    /// The declaring tokens of each name that some scope declares, the innermost one last: however deep blocks nest, a name
    /// is found at once.
    locals: HashMap<&'a str, Vec<usize>>,
}

const KEYWORDS: &str = "alias break case const const_assert continue continuing default diagnostic discard else \
    enable false fn for if let loop override requires return struct switch true var while";

fn is_keyword(word: &str) -> bool {
    KEYWORDS.split(' ').any(|keyword| keyword == word)
}

/// Attributes whose arguments are names of their own kind, not expressions.
const NAME_ATTRIBUTES: &[&str] = &["builtin", "interpolate", "diagnostic", "blend_src"];

impl<'a> Walker<'_, 'a> {
    fn declaration(mut self, global: &GlobalDecl) {
        if global.kind == GlobalKind::Directive {
            return;
        }
        if let Some(name) = global.name {
            self.outline.roles[name] = Role::Global;
        }
        let skip = |at: usize| Some(at) == global.name || at == global.keyword;
        match global.kind {
            GlobalKind::Function => self.function(global),
            GlobalKind::Struct => {
                for at in global.tokens.clone().filter(|&at| !skip(at)) {
                    let member = self.outline.word(at + 1) == ":";
                    if !member {
                        self.reference(at);
                    }
                }
            }
            _ => {
                for at in global.tokens.clone().filter(|&at| !skip(at)) {
                    self.reference(at);
                }
            }
        }
    }

    /// Gives token `at` the role of whatever its name refers to here.
    fn reference(&mut self, at: usize) {
        let token = self.outline.tokens.tokens[at];
        if token.kind != TokenKind::Word || is_keyword(token.text) || token.text == "_" {
            return;
        }
        let before = |n: usize| at.checked_sub(n).map_or("", |at| self.outline.word(at));
        let context_name = matches!(before(1), "." | "@")
            || (before(1) == "<" && matches!(before(2), "var" | "ptr"))
            || (before(1) == "(" && before(3) == "@" && NAME_ATTRIBUTES.contains(&before(2)));
        if context_name {
            return;
        }
        let declared = self.locals.get(token.text);
        self.outline.roles[at] = match declared.and_then(|declared| declared.last()) {
            Some(&declared) => Role::Local(declared),
            None if self.globals.contains_key(token.text) => Role::Global,
            None => Role::Predeclared,
        };
    }

    fn function(&mut self, global: &GlobalDecl) {
        let tokens = global.tokens.clone();
        let (Some(name), Some(open)) = (
            global.name,
            tokens
                .clone()
                .skip(1)
                .find(|&at| at > global.keyword && self.outline.word(at) == "("),
        ) else {
            return;
        };
        let close = self.outline.closing(open).min(tokens.end);
        let Some(body) = (close..tokens.end).find(|&at| self.outline.word(at) == "{") else {
            return;
        };
        for at in tokens.start..global.keyword {
            self.reference(at);
        }
        let params = self.params(open + 1..close);
        let result = if self.outline.word(close + 1) == "-" {
            (close + 3).min(body)..body
        } else {
            body..body
        };
        for at in close..body {
            self.reference(at);
        }
        let function = self.outline.functions.len();
        let names = params.iter().map(|param| param.name).collect();
        self.outline
            .function_by_name
            .insert(self.outline.word(name), function);
        self.outline.functions.push(FunctionDecl {
            keyword: global.keyword,
            name,
            params,
            result,
            body: body..tokens.end,
            shadows_result: false,
        });
        self.body(body..tokens.end, names, function);
        // Now that its locals are known.
        let hides_result = (self.outline).hides_result(&self.outline.functions[function]);
        self.outline.functions[function].shadows_result = hides_result;
    }

    /// A local is visible from here to the end of the innermost scope.
    fn declare(&mut self, name: usize) {
        if let Some(scope) = self.scopes.last_mut() {
            let text = self.outline.tokens.tokens[name].text;
            scope.names.push(text);
            self.locals.entry(text).or_default().push(name);
        }
    }

    /// Ends the innermost scope.
    fn leave(&mut self) -> Option<Scope<'a>> {
        let scope = self.scopes.pop()?;
        for name in &scope.names {
            if let Some(declared) = self.locals.get_mut(name) {
                declared.pop();
            }
        }
        Some(scope)
    }

    fn params(&mut self, tokens: Range<usize>) -> Vec<ParamDecl> {
        let mut params: Vec<ParamDecl> = Vec::new();
        let mut depth = 0usize;
        for at in tokens {
            let word = self.outline.word(at);
            if depth == 0 && self.outline.word(at + 1) == ":" {
                self.outline.roles[at] = Role::Local(at);
                params.push(ParamDecl {
                    name: at,
                    ty: at + 2..at + 2,
                });
                continue;
            }
            match word {
                "(" | "[" | "<" => depth += 1,
                ")" | "]" | ">" => depth = depth.saturating_sub(1),
                "," if depth == 0 => continue,
                _ => {}
            }
            // Tokens that follow each other from the colon on are the type; the comma leaves a gap.
            if let Some(param) = params.last_mut().filter(|param| param.ty.end == at) {
                param.ty.end = at + 1;
            }
            self.reference(at);
        }
        params
    }

    fn body(&mut self, tokens: Range<usize>, mut params: Vec<usize>, function: usize) {
        let mut pending: Option<usize> = None; // declared at the next `;`
        let mut expect_name = None; // the token that is a declaration's name
        let mut loop_keyword = None;
        let mut continuing = false;
        for at in tokens {
            if expect_name == Some(at) {
                self.outline.roles[at] = Role::Local(at);
                pending = Some(at);
                continue;
            }
            match self.outline.word(at) {
                "{" => {
                    let inherited = self.scopes.last().is_some_and(|scope| scope.continuing);
                    let body_of = loop_keyword.take().map(|keyword| {
                        self.outline.loops.push(LoopDecl {
                            keyword,
                            body: at..at + 1,
                            function,
                            in_continuing: inherited,
                        });
                        self.outline.loops.len() - 1
                    });
                    self.scopes.push(Scope {
                        names: Vec::new(),
                        is_for: false,
                        continuing: inherited || std::mem::take(&mut continuing),
                        body_of,
                    });
                    // Those of the function, in the first one.
                    for param in std::mem::take(&mut params) {
                        self.declare(param);
                    }
                }
                "}" => {
                    if let Some(index) = self.leave().and_then(|scope| scope.body_of) {
                        self.outline.loops[index].body.end = at + 1;
                    }
                    if self.scopes.last().is_some_and(|scope| scope.is_for) {
                        self.leave();
                    }
                    pending = None;
                }
                ";" => {
                    if let Some(name) = pending.take() {
                        self.declare(name);
                    }
                }
                "let" | "const" => expect_name = Some(at + 1),
                "var" => expect_name = Some(skip_template(&self.outline.tokens.tokens, at + 1)),
                "for" => {
                    let continuing = self.scopes.last().is_some_and(|scope| scope.continuing);
                    self.scopes.push(Scope {
                        names: Vec::new(),
                        is_for: true,
                        continuing,
                        body_of: None,
                    });
                    loop_keyword = Some(at);
                }
                "while" | "loop" => loop_keyword = Some(at),
                "continuing" => continuing = true,
                _ => self.reference(at),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text with every module-scope name of the file in angle brackets and every local in parentheses.
    fn marked(text: &str) -> String {
        let outline = Outline::new(text);
        let mut out = String::new();
        let mut last = 0;
        for (token, role) in outline.tokens.tokens.iter().zip(&outline.roles) {
            out.push_str(&text[last..token.start]);
            match role {
                Role::Global => out.push_str(&format!("<{}>", token.text)),
                Role::Local(_) => out.push_str(&format!("({})", token.text)),
                _ => out.push_str(token.text),
            }
            last = token.end();
        }
        out + &text[last..]
    }

    #[test]
    fn a_local_is_visible_from_the_end_of_its_declaration() {
        assert_eq!(
            marked("fn n() -> f32 { let n = n(); return n; }"),
            "fn <n>() -> f32 { let (n) = <n>(); return (n); }"
        );
    }

    #[test]
    fn blocks_end_shadowing() {
        assert_eq!(
            marked("const k = 1; fn f() { { var k = 2; k += k; } let a = k; }"),
            "const <k> = 1; fn <f>() { { var (k) = 2; (k) += (k); } let (a) = <k>; }"
        );
    }

    #[test]
    fn a_for_variable_lives_in_header_and_body_only() {
        assert_eq!(
            marked("const i = 9; fn f() { for (var i = i; i < 3; i++) { g(i); } h(i); }"),
            "const <i> = 9; fn <f>() { for (var (i) = <i>; (i) < 3; (i)++) { g((i)); } h(<i>); }"
        );
    }

    #[test]
    fn parameters_shadow_in_the_body_but_not_in_the_header() {
        assert_eq!(
            marked("alias T = f32; fn f(T: T, b: array<T, 2>) -> T { return T; }"),
            "alias <T> = f32; fn <f>((T): <T>, (b): array<<T>, 2>) -> <T> { return (T); }"
        );
    }

    #[test]
    fn members_attributes_and_address_spaces_are_not_references() {
        assert_eq!(
            marked(
                "struct S { @size(n) n: f32, m: S2 } const n = 16; struct S2 { a: f32 } fn function() {} fn f(s: S, p: ptr<function, f32>) { s.n = 1; var<function> n = s.m.a; }"
            ),
            "struct <S> { @size(<n>) n: f32, m: <S2> } const <n> = 16; struct <S2> { a: f32 } fn <function>() {} fn <f>((s): <S>, (p): ptr<function, f32>) { (s).n = 1; var<function> (n) = (s).m.a; }"
        );
    }

    #[test]
    fn functions_and_loops_are_found() {
        let text = "fn f(a: array<f32, 4>, @align(4) b: f32) -> vec3<f32> { loop { if a { break; } continuing { for (;;) {} } } while a { } }";
        let outline = Outline::new(text);
        let f = &outline.functions[0];
        let types: Vec<_> = f
            .params
            .iter()
            .map(|p| &text[outline.span_of(&p.ty)])
            .collect();
        assert_eq!(types, ["array<f32, 4>", "f32"]);
        assert_eq!(&text[outline.span_of(&f.result)], "vec3<f32>");
        let loops: Vec<_> = outline
            .loops
            .iter()
            .map(|l| (outline.word(l.keyword), l.in_continuing))
            .collect();
        assert_eq!(loops, [("loop", false), ("for", true), ("while", false)]);
        assert!(text[outline.span_of(&outline.loops[0].body)].ends_with("{} } }"));
    }

    #[test]
    fn broken_text_is_survived() {
        for text in [
            "fn",
            "fn (",
            "fn f(",
            "fn f() {",
            "}}}}",
            "var<",
            "fn f() { let",
            "fn f(a:",
            "struct {",
            "for",
            "@",
            ")",
            "fn f() -> { for (",
        ] {
            let _ = Outline::new(text);
        }
    }
}
