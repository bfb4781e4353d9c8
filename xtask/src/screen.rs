//! A screen for the tests of the window: an X server without a monitor, a window manager, and a hand. Where they can't be had, these
//! tests are skipped, and say so.

use crate::steps::Step;
use crate::vulkan;

/// Each program, with how it is asked for without doing anything, and Debian's package.
const PROGRAMS: [(&str, &str, &str); 3] = [
    ("Xvfb", "-help", "xvfb"),
    ("openbox", "--version", "openbox"),
    // Fails without a screen.
    ("xdotool", "version", "xdotool"),
];

const BY_HAND: &str = "The window's tests on a screen need Xvfb, openbox and xdotool";

/// Finds what the tests start, or installs it with apt; tells what is missing otherwise.
pub(crate) fn ensure() {
    if !cfg!(target_os = "linux") {
        println!("skipped: it is X11's");
        return;
    }
    let missing = || {
        let missing = PROGRAMS
            .into_iter()
            .filter(|(program, flag, _)| !Step::new(*program).args([*flag]).starts());
        missing.map(|(_, _, package)| package).collect::<Vec<_>>()
    };
    let packages = missing();
    if packages.is_empty() {
        println!("Xvfb, openbox and xdotool are there");
        return;
    }
    if let Err(error) = vulkan::install_packages(&packages, BY_HAND) {
        println!("{error:#}");
    }
    let packages = missing();
    if !packages.is_empty() {
        println!(
            "skipped: the window on a screen, without {}",
            packages.join(", ")
        );
    }
}
