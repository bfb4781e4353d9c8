//! Characters that the window's own fonts lack: names of materials, files and cameras may be in any script. Fonts of the system that
//! have them are looked for on a thread, once such a character is to be shown; until then, and where there is none, a box is.

mod faces;

use std::collections::BTreeSet;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};

use egui::{Context, FallbackRequest, FontInsert, FontProvider};
use fontdb::Database;

/// Characters that are looked for at most: a text with more other ones is no name.
const MOST_CHARACTERS: usize = 1 << 14;

/// Finds fonts for characters that there is none for yet.
pub(crate) struct Glyphs {
    known: Arc<Mutex<Known>>,
    /// What lists the fonts that there are.
    list: fn() -> Database,
    search: Search,
}

/// What is known of characters that the window's own fonts lack.
#[derive(Default)]
struct Known {
    fonts: Vec<Font>,
    /// Not looked for yet.
    wanted: BTreeSet<char>,
    /// Looked for, wanted, or being looked for.
    asked: BTreeSet<char>,
}

/// A font with the characters that it was looked for, and has.
struct Font {
    insert: FontInsert,
    characters: BTreeSet<char>,
}

enum Search {
    /// The fonts of the system, once they are known.
    Rests(Option<Database>),
    Runs(Receiver<(Database, Vec<Font>)>),
    /// There can be none.
    Failed,
}

impl Glyphs {
    /// Has a window's texts use fonts of the system from now on.
    pub(crate) fn of_system(ctx: &Context) -> Self {
        Self::from(ctx, faces::of_system)
    }

    /// The same with fonts from elsewhere.
    fn from(ctx: &Context, list: fn() -> Database) -> Self {
        let glyphs = Self {
            known: Arc::default(),
            list,
            search: Search::Rests(None),
        };
        glyphs.install(ctx);
        glyphs
    }

    fn install(&self, ctx: &Context) {
        ctx.set_font_providers(vec![Arc::new(Provider(Arc::clone(&self.known)))]);
    }

    /// Looks for what the last frames lacked, and shows what was found: to be called each frame.
    pub(crate) fn update(&mut self, ctx: &Context) {
        if let Search::Runs(search) = &self.search {
            match search.try_recv() {
                Ok((database, fonts)) => {
                    self.search = Search::Rests(Some(database));
                    if !fonts.is_empty() {
                        lock(&self.known).fonts.extend(fonts);
                        // What was missed is asked for again.
                        self.install(ctx);
                    }
                }
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => self.search = Search::Failed,
            }
        }
        let Search::Rests(database) = &mut self.search else {
            return;
        };
        let wanted = std::mem::take(&mut lock(&self.known).wanted);
        if wanted.is_empty() {
            return;
        }
        let (list, database) = (self.list, database.take());
        let (sender, receiver) = channel();
        let ctx = ctx.clone();
        let search = move || {
            let database = database.unwrap_or_else(list);
            let fonts = faces::find(&database, wanted, &faces::locale());
            // The window may be gone by now.
            let _ = sender.send((database, fonts));
            ctx.request_repaint();
        };
        // Where the system starts no more threads, boxes stay.
        let begun = std::thread::Builder::new()
            .name("fonts".to_owned())
            .spawn(search);
        self.search = match begun {
            Ok(_) => Search::Runs(receiver),
            Err(_) => Search::Failed,
        };
    }
}

impl Glyphs {
    /// Whether boxes that are shown may become letters.
    pub(crate) fn is_looking(&self) -> bool {
        match self.search {
            Search::Runs(_) => true,
            Search::Rests(_) => !lock(&self.known).wanted.is_empty(),
            Search::Failed => false,
        }
    }
}

/// What egui asks. It doesn't wait: what isn't known yet is noted.
struct Provider(Arc<Mutex<Known>>);

impl FontProvider for Provider {
    fn font_for(&self, request: &FallbackRequest<'_>) -> Option<FontInsert> {
        let character = request.cluster.chars().next()?;
        let mut known = lock(&self.0);
        let mut fonts = known.fonts.iter();
        if let Some(font) = fonts.find(|font| font.characters.contains(&character)) {
            return Some(font.insert.clone());
        }
        let is_new = is_common(character)
            && known.asked.len() < MOST_CHARACTERS
            && known.asked.insert(character);
        if is_new {
            known.wanted.insert(character);
        }
        None
    }
}

/// Whether it means the same in all fonts, and is to be seen.
fn is_common(character: char) -> bool {
    let is_private = matches!(character, '\u{e000}'..='\u{f8ff}' | '\u{f0000}'..);
    !is_private && !character.is_control() && !character.is_whitespace()
}

fn lock(known: &Mutex<Known>) -> std::sync::MutexGuard<'_, Known> {
    known.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use egui::{FontDefinitions, FontId, RawInput};

    use super::*;

    /// In the font for code, but not in that of texts.
    const IN_HACK: char = '⊢';
    /// In neither.
    const NOWHERE: char = '한';

    fn hack() -> Database {
        let mut database = Database::new();
        let fonts = FontDefinitions::default();
        database.load_font_data(fonts.font_data["Hack"].bytes().to_owned());
        database.load_font_data(b"no font at all".to_vec());
        database
    }

    fn panics() -> Database {
        panic!("nobody has been asked for a font")
    }

    /// Shows a text; whether all of it can be read.
    fn can_read(ctx: &Context, glyphs: &mut Glyphs, text: &str) -> bool {
        let mut can = false;
        let mut shown = ctx.run_ui(RawInput::default(), |ui| {
            ui.label(text);
            can = ui.fonts_mut(|fonts| fonts.has_glyphs(&FontId::proportional(14.0), text));
            glyphs.update(ui.ctx());
        });
        // Nobody paints it.
        shown.textures_delta.clear();
        can
    }

    fn wait() {
        std::thread::sleep(Duration::from_millis(5));
    }

    #[test]
    fn a_character_is_shown_once_a_font_has_been_found() {
        let ctx = Context::default();
        let mut glyphs = Glyphs::from(&ctx, hack);
        let text = format!("a{IN_HACK}");
        assert!(!can_read(&ctx, &mut glyphs, &text), "nobody waits for it");
        assert!(glyphs.is_looking());
        let end = Instant::now() + Duration::from_secs(60);
        while !can_read(&ctx, &mut glyphs, &text) {
            assert!(Instant::now() < end);
            wait();
        }
        assert!(!glyphs.is_looking());
        // What no font has is looked for once.
        for _ in 0..3 {
            assert!(!can_read(&ctx, &mut glyphs, &NOWHERE.to_string()));
            while let Search::Runs(_) = glyphs.search {
                wait();
                glyphs.update(&ctx);
            }
        }
        assert!(lock(&glyphs.known).wanted.is_empty());
        assert_eq!(lock(&glyphs.known).fonts.len(), 1);
        assert!(can_read(&ctx, &mut glyphs, &text));
    }

    #[test]
    fn fonts_are_listed_only_where_one_is_missing() {
        let ctx = Context::default();
        let mut glyphs = Glyphs::from(&ctx, panics);
        assert!(can_read(&ctx, &mut glyphs, "Grün, façade, бронза, μ"));
        assert!(matches!(glyphs.search, Search::Rests(None)));
        // Those that mean something else in each font are nobody's.
        assert!(!can_read(&ctx, &mut glyphs, "\u{e123}"));
        assert!(matches!(glyphs.search, Search::Rests(None)));
    }

    #[test]
    fn a_search_that_ends_without_a_word_leaves_boxes() {
        fn hopeless() -> Database {
            // As a panic would, but without its message.
            std::panic::resume_unwind(Box::new(()))
        }
        let ctx = Context::default();
        let mut glyphs = Glyphs::from(&ctx, hopeless);
        let end = Instant::now() + Duration::from_secs(60);
        while !matches!(glyphs.search, Search::Failed) {
            assert!(!can_read(&ctx, &mut glyphs, "한"));
            assert!(Instant::now() < end);
            wait();
        }
        assert!(!can_read(&ctx, &mut glyphs, "국"));
    }
}
