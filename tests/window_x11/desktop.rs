//! A screen of its own without a monitor (Xvfb), with a window manager (openbox) and a hand (xdotool), and what is to be seen there.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A slow machine that others use too needs that long for a picture.
pub(crate) const PATIENCE: Duration = Duration::from_secs(180);
/// How often is looked.
const LOOK_AGAIN: Duration = Duration::from_millis(100);
/// Pixels of the screen: room to maximise a window.
const SCREEN: &str = "1600x1000x24";

/// No decorations, so that windows are where they say; keys that maximise and close as a user's desktop has them.
const OPENBOX: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<openbox_config xmlns="http://openbox.org/3.4/rc">
  <keyboard>
    <keybind key="W-m"><action name="ToggleMaximize"/></keybind>
    <keybind key="W-q"><action name="Close"/></keybind>
  </keyboard>
  <applications><application class="*"><decor>no</decor></application></applications>
</openbox_config>
"#;

/// Ended when it is dropped.
pub(crate) struct Running(pub(crate) Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A part of the screen: left, top, width and height in pixels.
pub(crate) type Area = [usize; 4];

pub(crate) struct Desktop {
    /// As `DISPLAY` has it.
    pub(crate) display: String,
    /// Where the server keeps what it shows.
    screen: PathBuf,
    _manager: Running,
    _server: Running,
}

impl Desktop {
    /// Starts it, with its files in that folder.
    ///
    /// # Errors
    /// One of its programs isn't there.
    pub(crate) fn start(folder: &Path) -> Result<Self, String> {
        let missing = |what: &str| format!("{what} is not installed");
        let is_there = |name: &str, flag: &str| {
            let mut command = Command::new(name);
            let quiet = command.stdout(Stdio::null()).stderr(Stdio::null());
            let run = quiet.arg(flag).status();
            run.map(drop).map_err(|_| missing(name))
        };
        is_there("xdotool", "version")?;
        let mut server = Command::new("Xvfb")
            // It takes a number that is free, and says it there; and it goes on when a first client goes before a second comes.
            .args(["-displayfd", "1", "-noreset", "-nolisten", "tcp"])
            .args(["-screen", "0", SCREEN, "-fbdir"])
            .arg(folder)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|_| missing("Xvfb"))?;
        let mut said = BufReader::new(server.stdout.take().expect("piped"));
        let server = Running(server);
        let mut number = String::new();
        said.read_line(&mut number).expect("Xvfb says its number");
        assert!(!number.trim().is_empty(), "Xvfb has no display to offer");
        let display = format!(":{}", number.trim());
        let rules = folder.join("openbox.xml");
        std::fs::write(&rules, OPENBOX).expect("a file");
        let manager = Command::new("openbox")
            .arg("--config-file")
            .arg(&rules)
            .env("DISPLAY", &display)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|_| missing("openbox"))?;
        let desktop = Self {
            display,
            screen: folder.join("Xvfb_screen0"),
            _manager: Running(manager),
            _server: server,
        };
        // Keys reach nobody before there is a window manager.
        desktop.until("the window manager", || {
            let windows = desktop.hand(&["getactivewindow"]);
            let desktops = desktop.hand(&["get_num_desktops"]);
            (windows.is_some() || desktops.is_some()).then_some(())
        });
        Ok(desktop)
    }

    /// What xdotool says, where it does not fail.
    pub(crate) fn hand(&self, arguments: &[&str]) -> Option<String> {
        let output = Command::new("xdotool")
            .args(arguments)
            .env("DISPLAY", &self.display)
            .stdin(Stdio::null())
            .output()
            .expect("xdotool starts");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        output.status.success().then_some(text)
    }

    /// Looks until there is something.
    #[track_caller]
    pub(crate) fn until<T>(&self, what: &str, mut look: impl FnMut() -> Option<T>) -> T {
        let end = Instant::now() + PATIENCE;
        loop {
            if let Some(found) = look() {
                return found;
            }
            assert!(Instant::now() < end, "never came: {what}");
            std::thread::sleep(LOOK_AGAIN);
        }
    }

    /// What is shown now.
    pub(crate) fn picture(&self) -> Picture {
        let bytes = std::fs::read(&self.screen).expect("the server keeps its screen");
        Picture::read(&bytes).expect("as X window dumps are")
    }
}

/// The screen, row by row.
pub(crate) struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// An X window dump of four bytes per pixel; its header is described in X11's `XWDFile.h`.
    fn read(bytes: &[u8]) -> Option<Self> {
        let word = |index: usize| {
            let word = bytes.get(4 * index..4 * index + 4)?;
            Some(u32::from_be_bytes(word.try_into().ok()?) as usize)
        };
        let (header, width, height) = (word(0)?, word(4)?, word(5)?);
        let is_little = word(7)? == 0;
        let (bits, stride, colors) = (word(11)?, word(12)?, word(19)?);
        if bits != 32 {
            return None;
        }
        let rows = bytes.get(header + 12 * colors..)?.chunks_exact(stride);
        let pixel = |bytes: &[u8]| match is_little {
            true => [bytes[2], bytes[1], bytes[0]],
            false => [bytes[1], bytes[2], bytes[3]],
        };
        let pixels: Vec<_> = rows
            .take(height)
            .flat_map(|row| row[..4 * width].chunks_exact(4).map(pixel))
            .collect();
        (pixels.len() == width * height).then_some(Self {
            width,
            height,
            pixels,
        })
    }

    /// The pixels of a part.
    pub(crate) fn part(&self, [left, top, width, height]: Area) -> Vec<[u8; 3]> {
        let rows = top.min(self.height)..(top + height).min(self.height);
        let columns = left.min(self.width)..(left + width).min(self.width);
        rows.flat_map(|y| {
            columns
                .clone()
                .map(move |x| self.pixels[y * self.width + x])
        })
        .collect()
    }

    /// How much the mean of a block of a part has changed at most, 0 to 255: noise is little, another thing is much.
    pub(crate) fn change(&self, before: &Self, [left, top, width, height]: Area) -> f64 {
        const BLOCKS: usize = 8;
        let (w, h) = (width / BLOCKS, height / BLOCKS);
        let blocks = (0..BLOCKS).flat_map(|y| (0..BLOCKS).map(move |x| (x, y)));
        let changes = blocks.map(|(x, y)| {
            let area = [left + x * w, top + y * h, w, h];
            (self.mean(area) - before.mean(area)).abs()
        });
        changes.fold(0.0, f64::max)
    }

    /// Of all channels of a part, 0 to 255.
    pub(crate) fn mean(&self, area: Area) -> f64 {
        let pixels = self.part(area);
        let sum: f64 = pixels.iter().flatten().map(|byte| f64::from(*byte)).sum();
        sum / (3 * pixels.len().max(1)) as f64
    }
}
