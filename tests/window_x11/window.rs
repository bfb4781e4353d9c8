//! The program's window, and what a user would notice of it. Nothing waits a fixed time: all is looked for until it is there.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::desktop::{Area, Desktop, Picture, Running};

/// Colours that a picture has at least: a panel has some dozens.
const COLOURS: usize = 300;
/// The colour of errors in the window (`viewer/src/appearance.rs`), and how many pixels of it are no noise but a text.
const ERROR: [u8; 3] = [255, 125, 115];
const TEXT: usize = 40;
/// Pixels of some letters: more than those of a cursor.
const LETTERS: usize = 200;
/// Of 255, that the mean of a block changes where something else is shown. Noise of the first sample stays below.
const CHANGE: f64 = 10.0;

/// What is left of the mean of a picture behind a question, at most: noise and another exposure's beginning change it less.
const DARKER: f64 = 0.75;

/// What none of its lines may be about.
const WORDS: [&str; 6] = ["error", "panic", "scissor", "surface", "validation", "lost"];

pub(crate) struct Window<'a> {
    desktop: &'a Desktop,
    program: Running,
    /// As the window system calls it.
    id: String,
    said: PathBuf,
    /// What it prints when it is closed.
    figures: PathBuf,
}

impl<'a> Window<'a> {
    /// Opens the look in that folder. What the program keeps is kept there, too.
    pub(crate) fn open(desktop: &'a Desktop, folder: &Path) -> Self {
        let said = folder.join("stderr");
        let stderr = std::fs::File::create(&said).expect("a file");
        let figures = folder.join("stdout");
        let stdout = std::fs::File::create(&figures).expect("a file");
        let path = std::env::var_os("PATH").unwrap_or_default();
        let paths = std::iter::once(folder.to_owned()).chain(std::env::split_paths(&path));
        let mut command = Command::new(env!("CARGO_BIN_EXE_patina"));
        for name in ["HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_CACHE_HOME"] {
            command.env(name, folder);
        }
        let program = command
            .args(["view", "demo.gltf", "--look", "demo.look.toml", "--figures"])
            .current_dir(folder)
            .env("PATH", std::env::join_paths(paths).expect("paths"))
            .env("DISPLAY", &desktop.display)
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            // No dialog but the one of this test.
            .env("DBUS_SESSION_BUS_ADDRESS", "disabled:")
            .stdin(Stdio::null())
            .stdout(stdout)
            .stderr(stderr)
            .spawn()
            .expect("patina starts");
        let mut window = Self {
            desktop,
            program: Running(program),
            id: String::new(),
            said,
            figures,
        };
        window.id = window.until("the window", |window| {
            let search = ["search", "--onlyvisible", "--name", "Patina"];
            let found = window.desktop.hand(&search)?;
            found.lines().next().map(str::to_owned)
        });
        window
    }

    /// Looks until there is something; the program has to live meanwhile, and has nothing to complain of.
    #[track_caller]
    fn until<T>(&mut self, what: &str, mut look: impl FnMut(&Self) -> Option<T>) -> T {
        let desktop = self.desktop;
        desktop.until(what, || {
            self.is_well(what);
            look(self)
        })
    }

    #[track_caller]
    fn is_well(&mut self, when: &str) {
        let said = std::fs::read_to_string(&self.said).unwrap_or_default();
        let ended = self.program.0.try_wait().expect("its state");
        assert!(ended.is_none(), "{when}: it ended with {ended:?}: {said}");
        let low = said.to_lowercase();
        let word = WORDS.into_iter().find(|word| low.contains(word));
        assert!(word.is_none(), "{when}: {said}");
    }

    fn hand(&self, arguments: &[&str]) {
        let done = self.desktop.hand(arguments);
        assert!(done.is_some(), "xdotool {}", arguments.join(" "));
    }

    /// Where it is on the screen.
    fn area(&self) -> Option<Area> {
        let said = self
            .desktop
            .hand(&["getwindowgeometry", "--shell", &self.id])?;
        let value = |name: &str| {
            let line = said.lines().find_map(|line| line.strip_prefix(name));
            line?.strip_prefix('=')?.parse::<usize>().ok()
        };
        Some([value("X")?, value("Y")?, value("WIDTH")?, value("HEIGHT")?])
    }

    /// The part in which the picture is, without what lies above, below and beside it.
    fn viewport(&self) -> Option<Area> {
        let [left, top, width, height] = self.area()?;
        // The panel beside it has a least width; bars may have several lines.
        let width = width.saturating_sub(400).max(width / 4);
        Some([left + 10, top + height / 5, width, height * 3 / 5])
    }

    /// Presses keys one after another.
    pub(crate) fn keys(&self, keys: &[&str]) {
        for key in keys {
            self.hand(&["key", key]);
        }
    }

    pub(crate) fn types(&self, text: &str) {
        self.hand(&["type", "--delay", "40", text]);
    }

    pub(crate) fn resize(&self, size: [i32; 2]) {
        let [width, height] = size.map(|side| side.to_string());
        self.hand(&["windowsize", &self.id, &width, &height]);
    }

    pub(crate) fn has_size(&mut self, [width, height]: [i32; 2]) {
        self.until("its size", |window| {
            let [_, _, w, h] = window.area()?;
            (w == width as usize && h == height as usize).then_some(())
        });
    }

    fn point(&self, [x, y]: [i32; 2]) {
        let (x, y) = (x.to_string(), y.to_string());
        self.hand(&["mousemove", "--window", &self.id, &x, &y]);
    }

    /// A picture, neither black nor empty, and no message of an error over it.
    #[track_caller]
    pub(crate) fn shows_a_picture(&mut self, when: &str) -> Picture {
        self.until(&format!("a picture {when}"), |window| {
            let area = window.viewport()?;
            let picture = window.desktop.picture();
            let pixels = picture.part(area);
            let errors = picture.part(window.area()?).into_iter();
            let errors = errors.filter(|pixel| *pixel == ERROR).count();
            assert!(errors < TEXT, "{when}: the window tells of an error");
            let dark = pixels.iter().filter(|pixel| **pixel == [0; 3]).count();
            let colours: HashSet<_> = pixels.iter().collect();
            let is_there = colours.len() >= COLOURS && 2 * dark < pixels.len();
            is_there.then_some(picture)
        })
    }

    /// Waits until a part has changed since then.
    #[track_caller]
    fn changes(&mut self, what: &str, before: &Picture, area: Area) {
        self.until(what, |window| {
            let change = window.desktop.picture().change(before, area);
            (change > CHANGE).then_some(())
        });
    }

    /// Drags in the picture, which follows.
    #[track_caller]
    pub(crate) fn drag(&mut self, from: [i32; 2], to: [i32; 2]) {
        let before = self.shows_a_picture("before it is dragged");
        self.point(from);
        self.hand(&["mousedown", "1"]);
        for step in 1..=10 {
            let at = |k: usize| from[k] + (to[k] - from[k]) * step / 10;
            self.point([at(0), at(1)]);
        }
        // Else it may be let go before there is a picture, and there is nothing to tell of pictures while it is dragged.
        let area = self.viewport().expect("there is a window");
        self.changes("another view while it is dragged", &before, area);
        self.point([to[0] + 8, to[1]]);
        self.hand(&["mouseup", "1"]);
    }

    /// Waits for a title.
    #[track_caller]
    pub(crate) fn is_titled(&mut self, what: &str, is_meant: impl Fn(&str) -> bool) {
        self.until(&format!("the title of {what}"), |window| {
            let title = window.desktop.hand(&["getwindowname", &window.id])?;
            is_meant(title.trim()).then_some(())
        });
    }

    /// Clicks on a button, and waits until what it opens is there.
    #[track_caller]
    pub(crate) fn opens_a_menu(&mut self, at: [i32; 2]) {
        let before = self.desktop.picture();
        self.point(at);
        self.hand(&["click", "1"]);
        let [left, top, width, height] = self.area().expect("there is a window");
        let below = at[1] as usize + 20;
        let panel = [
            left + at[0] as usize,
            top + below,
            width - at[0] as usize,
            height - below,
        ];
        self.changes("a menu", &before, panel);
    }

    /// Presses keys, and waits until what is asked then has darkened the rest of the window.
    #[track_caller]
    pub(crate) fn asks(&mut self, keys: &[&str]) {
        let before = self.shows_a_picture("before it asks");
        let area = self.viewport().expect("there is a window");
        self.keys(keys);
        self.until("a question", |window| {
            let now = window.desktop.picture();
            (now.mean(area) < DARKER * before.mean(area)).then_some(())
        });
    }

    /// The left part of a dialog in the middle, where its fields begin.
    pub(crate) fn fields(&self) -> Vec<[u8; 3]> {
        let [left, top, width, height] = self.area().expect("there is a window");
        let area = [left + width / 2 - 200, top + height / 2 - 80, 260, 160];
        self.desktop.picture().part(area)
    }

    /// Waits until a field of the dialog has another text.
    #[track_caller]
    pub(crate) fn fills_in(&mut self, what: &str, before: &[[u8; 3]]) {
        self.until(what, |window| {
            let now = window.fields();
            let differ = now.iter().zip(before).filter(|(now, before)| now != before);
            (differ.count() > LETTERS).then_some(())
        });
    }

    /// Is ended from outside: it closes in order. Gives what was said.
    pub(crate) fn ended(mut self) -> String {
        let id = self.program.0.id().to_string();
        let killed = Command::new("kill").args(["-TERM", &id]).status();
        assert!(killed.expect("kill starts").success());
        let program = &mut self.program.0;
        let ended = self
            .desktop
            .until("its end", || program.try_wait().expect("its state"));
        let said = std::fs::read_to_string(&self.said).unwrap_or_default();
        assert_eq!(ended.code(), Some(143), "{said}");
        said
    }

    /// Closes it, and the program ends as it should and tells how quickly it was.
    pub(crate) fn closes(mut self) {
        self.is_well("before it is closed");
        self.keys(&["super+q"]);
        let program = &mut self.program.0;
        let ended = self
            .desktop
            .until("its end", || program.try_wait().expect("its state"));
        let said = std::fs::read_to_string(&self.said).unwrap_or_default();
        assert!(ended.success(), "{ended}: {said}");
        let figures = std::fs::read_to_string(&self.figures).expect("what it printed");
        for told in ["first picture ", "while dragging ", "ms to a picture"] {
            assert!(figures.contains(told), "{told:?} is missing: {figures}");
        }
    }
}
