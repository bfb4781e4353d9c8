//! What people write who know GLSL or HLSL, and how WGSL says it.
//!
//! naga's parser would say which token it had expected; these constructs are found by their tokens before, so that the
//! message is about the construct, and so that the rest of the file can be read without it.

use std::ops::Range;

use crate::diagnostic::{Diagnostic, SourceFile};
use crate::scope::{GlobalKind, Outline, Role};
use crate::tokens::TokenKind;

/// A construct of another language.
#[derive(Debug)]
pub(crate) struct Habit<'a> {
    pub(crate) diagnostic: Diagnostic,
    /// Tokens that the file is to be read without; of a statement, one is enough.
    pub(crate) tokens: Range<usize>,
    /// Names that they would declare.
    pub(crate) names: Vec<&'a str>,
}

/// Most that are told of one file: who writes another language has hundreds.
const MOST: usize = 20;

/// All constructs of other languages in a file.
pub(crate) fn habits<'a>(file: &SourceFile, outline: &Outline<'a>) -> Vec<Habit<'a>> {
    let reader = Reader { file, outline };
    let mut found = Vec::new();
    let mut at = 0;
    while at < outline.tokens.tokens.len() && found.len() < MOST {
        match reader.habit(at) {
            Some(habit) => {
                at = habit.tokens.end.max(at + 1);
                found.push(habit);
            }
            None => at += 1,
        }
    }
    found
}

/// How WGSL calls a type of another language; its own names stay. None where it is no type's name.
fn type_name(word: &str) -> Option<&'static str> {
    const SAME: [&str; 22] = [
        "f32", "i32", "u32", "bool", "vec2f", "vec3f", "vec4f", "vec2i", "vec3i", "vec4i", "vec2u",
        "vec3u", "vec4u", "mat2x2f", "mat3x3f", "mat4x4f", "sam2D", "ramp1D", "vec2h", "vec3h",
        "vec4h", "f16",
    ];
    Some(match word {
        "float" | "half" | "double" => "f32",
        "int" => "i32",
        "uint" => "u32",
        "vec2" | "float2" | "half2" => "vec2f",
        "vec3" | "float3" | "half3" => "vec3f",
        "vec4" | "float4" | "half4" => "vec4f",
        "ivec2" | "int2" => "vec2i",
        "ivec3" | "int3" => "vec3i",
        "ivec4" | "int4" => "vec4i",
        "uvec2" | "uint2" => "vec2u",
        "uvec3" | "uint3" => "vec3u",
        "uvec4" | "uint4" => "vec4u",
        "bvec2" | "bool2" => "vec2<bool>",
        "bvec3" | "bool3" => "vec3<bool>",
        "bvec4" | "bool4" => "vec4<bool>",
        "mat2" | "float2x2" => "mat2x2f",
        "mat3" | "float3x3" => "mat3x3f",
        "mat4" | "float4x4" => "mat4x4f",
        "sampler2D" | "Texture2D" => "sam2D",
        "void" => "",
        _ => return SAME.iter().copied().find(|&name| name == word),
    })
}

/// What to write instead of a name that WGSL doesn't have.
pub(crate) fn instead_of(word: &str) -> Option<String> {
    let text = match word {
        "lerp" => "`mix(a, b, t)` is what `lerp` is in other languages",
        "mod" | "fmod" => {
            "write `x - y * floor(x / y)`, or `x % y`, whose result has the sign of `x`"
        }
        "frac" => "write `fract(x)`",
        "rsqrt" | "inversesqrt" => "write `inverseSqrt(x)`",
        "mul" => "write `a * b`",
        "atan2f" => "write `atan2(y, x)`",
        "clamp01" | "saturated" => "write `saturate(x)`",
        "lessThan" => "write `a < b`, which compares component by component",
        "greaterThan" => "write `a > b`, which compares component by component",
        "equal" => "write `a == b`, which compares component by component",
        "ddx" | "ddy" | "dFdx" | "dFdy" => {
            "hits have no neighbouring pixels: `readAttr(Footprint)` tells how wide the pixel is"
        }
        "texture" | "texture2D" | "tex2d" | "texelFetch" => {
            "write `tex2D(image, uv)`, with `image: sam2D` a parameter of `userProc`"
        }
        "textureLod" | "texture2DLod" | "tex2Dlod" | "tex2Dlevel" => {
            "write `tex2DLod(image, uv, lod)`, with `image: sam2D` a parameter of `userProc`"
        }
        "textureSize" => "write `texSize(image)`",
        "noise" | "noise1" | "noise2" | "noise3" | "snoise" | "cnoise" | "perlin" | "simplex"
        | "fbm" | "voronoi" => {
            "the standard functions have `perlin3D`, `simplex3D`, `fbm3D`, `voronoi3D` and others; or link a node of `fbm` or `voronoi` to a parameter"
        }
        "rand" | "random" | "hash" => {
            "the standard functions have `randomOf(vec4f)`, `random3to1(vec3u)` and others; or use `readAttr(ObjectRandom)`"
        }
        "iTime" | "time" | "u_time" => "write `readGlobal(Time).x`",
        "iResolution" | "u_resolution" => "write `readGlobal(Resolution).xy`",
        "gl_FragCoord" | "fragCoord" | "vUv" | "vTexCoord" => {
            "write `readAttr(TexCoord0).xy`: a texture knows the surface, not the pixel"
        }
        "PI" | "M_PI" | "pi" => "WGSL has no constant for it: write `const PI = 3.14159265;`",
        "printf" | "print" => "a texture can't print: `patina texture eval` shows its value",
        _ => {
            let ty = type_name(word).filter(|ty| !ty.is_empty() && *ty != word)?;
            return Some(format!("WGSL calls it `{ty}`"));
        }
    };
    Some(text.to_owned())
}

struct Reader<'o, 'a> {
    file: &'o SourceFile,
    outline: &'o Outline<'a>,
}

impl<'a> Reader<'_, 'a> {
    fn word(&self, at: usize) -> &'a str {
        self.outline.word(at)
    }

    fn before(&self, at: usize) -> &'a str {
        at.checked_sub(1).map_or("", |at| self.word(at))
    }

    fn is_word(&self, at: usize) -> bool {
        let token = self.outline.tokens.tokens.get(at);
        token.is_some_and(|token| token.kind == TokenKind::Word)
    }

    fn error(&self, tokens: Range<usize>, message: String, note: &str) -> Habit<'a> {
        let span = self.outline.span_of(&tokens);
        Habit {
            diagnostic: Diagnostic::error(message)
                .with_label(self.file, span, "")
                .with_note(note),
            tokens,
            names: Vec::new(),
        }
    }

    /// The construct that begins with token `at`, if there is one.
    fn habit(&self, at: usize) -> Option<Habit<'a>> {
        match self.word(at) {
            "#" => Some(self.directive(at)),
            "?" => Some(self.error(
                at..at + 1,
                "WGSL has no `condition ? a : b`".into(),
                "write `select(b, a, condition)`, or use `if`",
            )),
            "+" | "-" => self.prefix_step(at),
            "do" if self.word(at + 1) == "{" => Some(self.error(
                at..at + 1,
                "WGSL has no `do`".into(),
                "write `loop { ... if !condition { break; } }`",
            )),
            word if self.is_word(at) && self.is_word(at + 1) => {
                let named = type_name(word).map(str::to_owned);
                let own = || self.is_own_type(at).then(|| word.to_owned());
                self.declaration(at, &named.or_else(own)?)
            }
            _ => None,
        }
    }

    /// A line of a preprocessor.
    fn directive(&self, at: usize) -> Habit<'a> {
        let text = self.outline.text;
        let start = self.outline.span(at).start;
        let line_end = text[start..]
            .find('\n')
            .map_or(text.len(), |end| start + end);
        let tokens = &self.outline.tokens.tokens;
        let end = tokens.partition_point(|token| token.start < line_end);
        let (word, name) = (self.word(at + 1), self.word(at + 2));
        let mut habit = match word {
            "include" => self.error(
                at..end,
                "a texture can't include other files".into(),
                "put it into `lib/NAME.wgsl` beside the texture and write `/// @use NAME`, or paste the functions that you need",
            ),
            "define" if self.word(at + 3) == "(" => self.error(
                at..end,
                "WGSL has no `#define`".into(),
                &format!("write a function: `fn {name}(x: f32) -> f32 {{ return ...; }}`"),
            ),
            "define" => self.error(
                at..end,
                "WGSL has no `#define`".into(),
                &format!("write a constant: `const {name} = ...;`"),
            ),
            _ => self.error(
                at..end,
                format!("WGSL has no preprocessor (`#{word}`)"),
                "remove the line",
            ),
        };
        if word == "define" && at + 2 < end {
            habit.names.push(name);
        }
        habit
    }

    /// `++i` as a statement.
    fn prefix_step(&self, at: usize) -> Option<Habit<'a>> {
        let sign = self.word(at);
        let adjacent = self.outline.span(at).end == self.outline.span(at + 1).start;
        let begins = matches!(self.before(at), ";" | "{" | "}");
        let is_step = self.word(at + 1) == sign && adjacent && begins && self.is_word(at + 2);
        is_step.then(|| {
            let name = self.word(at + 2);
            self.error(
                at..at + 3,
                format!("WGSL has no `{sign}{sign}{name}`"),
                &format!("write `{name}{sign}{sign}`"),
            )
        })
    }

    /// Whether token `at` names a struct or an alias of the file.
    fn is_own_type(&self, at: usize) -> bool {
        self.outline.roles[at] == Role::Global
            && self.outline.globals.iter().any(|global| {
                matches!(global.kind, GlobalKind::Struct | GlobalKind::Alias)
                    && global
                        .name
                        .is_some_and(|name| name != at && self.word(name) == self.word(at))
            })
    }

    /// `TYPE NAME`, with a type's name at `at` that WGSL calls `ty`.
    fn declaration(&self, at: usize, ty: &str) -> Option<Habit<'a>> {
        let name = self.word(at + 1);
        let before = self.before(at);
        let is_qualified = matches!(
            before,
            "in" | "out"
                | "inout"
                | "const"
                | "uniform"
                | "varying"
                | "static"
                | "highp"
                | "mediump"
                | "lowp"
        );
        if !is_qualified
            && !matches!(before, "" | ";" | "{" | "}" | "(" | ",")
            && !self.begins_line(at)
        {
            return None;
        }
        let start = at - usize::from(is_qualified);
        let mut functions = self.outline.functions.iter();
        let function = functions.find(|f| (f.keyword..f.body.end).contains(&at));
        let mut globals = self.outline.globals.iter();
        let global = globals.find(|global| (global.keyword..global.tokens.end).contains(&at));
        let what = format!("`{} {name}` is not how WGSL declares", self.word(at));
        let tokens = start..at + 2;
        Some(match (function, global.map(|global| global.kind)) {
            (Some(function), _) if !function.body.contains(&at) => self.error(
                tokens,
                format!("{what} a parameter"),
                &format!("write `{name}: {ty}`"),
            ),
            (None, Some(GlobalKind::Function)) => self.error(
                tokens,
                format!("{what} a parameter"),
                &format!("write `{name}: {ty}`"),
            ),
            (None, Some(GlobalKind::Struct)) => self.error(
                tokens,
                format!("{what} a member"),
                &format!("write `{name}: {ty},`"),
            ),
            (Some(_), _) => {
                let write = match self.word(at + 2) {
                    "[" => format!("write `var {name}: array<{ty}, N>;`"),
                    "=" if before == "const" => format!("write `const {name}: {ty} = ...;`"),
                    "=" if before == "(" => format!("write `var {name} = ...`"),
                    "=" => format!(
                        "write `let {name} = ...;`, or `var {name} = ...;` where it is changed later"
                    ),
                    _ => format!("write `var {name}: {ty};`"),
                };
                let mut habit = self.error(tokens, format!("{what} a variable"), &write);
                habit.names = self.names(at + 1);
                habit
            }
            (None, _) if self.word(at + 2) == "(" => self.function(start, at, ty),
            (None, _) => {
                let write = match before {
                    "uniform" | "varying" | "in" => {
                        "make it a parameter of `userProc`, or read it with `readAttr`".to_owned()
                    }
                    _ => format!("write `const {name}: {ty} = ...;`"),
                };
                let mut habit = self.error(tokens, format!("{what} a constant"), &write);
                habit.names = self.names(at + 1);
                let end = (at..self.outline.tokens.tokens.len()).find(|&t| self.word(t) == ";");
                habit.tokens.end = end.map_or(habit.tokens.end, |end| end + 1);
                habit
            }
        })
    }

    fn begins_line(&self, at: usize) -> bool {
        let between = match at.checked_sub(1) {
            Some(before) => self.outline.span(before).end..self.outline.span(at).start,
            None => return true,
        };
        self.outline.text[between].contains('\n')
    }

    /// The names of `TYPE a = 1.0, b, c;` from `a` on.
    fn names(&self, first: usize) -> Vec<&'a str> {
        let mut names = vec![self.word(first)];
        let mut depth = 0usize;
        for at in first + 1..self.outline.tokens.tokens.len() {
            match self.word(at) {
                "(" | "[" => depth += 1,
                ")" | "]" if depth == 0 => break,
                ")" | "]" => depth -= 1,
                ";" | "{" | "}" => break,
                "," if depth == 0 && self.is_word(at + 1) => names.push(self.word(at + 1)),
                _ => {}
            }
        }
        names
    }

    /// `TYPE NAME(...)` at module scope.
    fn function(&self, start: usize, at: usize, ty: &str) -> Habit<'a> {
        let name = self.word(at + 1);
        let close = self.outline.closing(at + 2);
        let end = match self.word(close + 1) {
            "{" => self.outline.closing(close + 1) + 1,
            ";" => close + 2,
            _ => close + 1,
        };
        let result = match ty {
            "" => String::new(),
            ty => format!(" -> {ty}"),
        };
        let parameters = self.parameters(at + 3..close);
        let mut habit = self.error(
            start..at + 2,
            format!(
                "`{} {name}(...)` is not how WGSL declares a function",
                self.word(at)
            ),
            &format!("write `fn {name}({parameters}){result} {{ ... }}`"),
        );
        if matches!(name, "main" | "mainImage") {
            let note = "the entry of a texture is `fn userProc(...) -> vec4f`";
            habit.diagnostic = habit.diagnostic.with_note(note);
        }
        habit.tokens = start..end;
        habit.names.push(name);
        habit
    }

    /// `in vec2 p, inout float x` as WGSL writes it.
    fn parameters(&self, tokens: Range<usize>) -> String {
        let mut written = Vec::new();
        let all: Vec<usize> = tokens.collect();
        for tokens in all.split(|&at| self.word(at) == ",").take(8) {
            let words: Vec<&str> = tokens.iter().map(|&at| self.word(at)).collect();
            let ty = words.iter().find_map(|word| type_name(word));
            let (Some(ty), Some(name)) = (ty, words.last()) else {
                continue;
            };
            written.push(match words.first() {
                Some(&"out" | &"inout") => format!("{name}: ptr<function, {ty}>"),
                _ => format!("{name}: {ty}"),
            });
        }
        written.join(", ")
    }
}
