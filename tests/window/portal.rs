//! Whether a free desktop shows file dialogs.

use burstscope::app::dialogs::free_desktop::shows_dialogs;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::process::{Child, Command, Stdio};
use zbus::connection::Builder;

struct Bus(Child, String);

impl Bus {
    fn start() -> Self {
        let arguments = ["--session", "--nofork", "--nopidfile", "--print-address"];
        let mut daemon = Command::new("dbus-daemon").args(arguments).stdout(Stdio::piped()).spawn().expect("it starts");
        let mut address = String::new();
        BufReader::new(daemon.stdout.take().expect("piped")).read_line(&mut address).expect("an address");
        Self(daemon, address.trim().to_owned())
    }

    fn builder(&self) -> zbus::Result<Builder<'_>> {
        Builder::address(self.1.as_str())
    }
}

impl Drop for Bus {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

struct Chooser;

#[zbus::interface(name = "org.freedesktop.portal.FileChooser")]
impl Chooser {
    #[zbus(property, name = "version")]
    fn version(&self) -> u32 {
        4
    }
}

struct Settings;

#[zbus::interface(name = "org.freedesktop.portal.Settings")]
impl Settings {
    #[zbus(property, name = "version")]
    fn version(&self) -> u32 {
        2
    }
}

const NAME: &str = "org.freedesktop.portal.Desktop";
const OBJECT: &str = "/org/freedesktop/portal/desktop";

#[needs::program("dbus-daemon")]
#[test]
fn a_portal_or_zenity_shows_dialogs_and_nothing_else_does() {
    let home = crate::shared::folder();
    let (with, without) = (home.join("with"), home.join("without"));
    [&with, &without].into_iter().for_each(|folder| std::fs::create_dir(folder).expect("made"));
    for (folder, mode) in [(&with, 0o755), (&without, 0o644)] {
        std::fs::write(folder.join("zenity"), "#!/bin/sh\n").expect("written");
        let mode = std::fs::Permissions::from_mode(mode);
        std::fs::set_permissions(folder.join("zenity"), mode).expect("set");
    }
    let bus = Bus::start();
    let both = || [&without, &with].map(|folder| shows_dialogs(bus.builder(), Some(folder.as_os_str())));
    assert_eq!(both(), [false, true], "no portal");
    let served = |builder: zbus::Result<Builder<'_>>| {
        let builder = builder.and_then(|builder| builder.name(NAME));
        pollster::block_on(builder.expect("a name").build()).expect("a service")
    };
    let other = served(bus.builder().and_then(|builder| builder.serve_at(OBJECT, Settings)));
    assert_eq!(both(), [false, true], "a portal that chooses no files");
    pollster::block_on(other.release_name(NAME)).expect("released");
    let portal = served(bus.builder().and_then(|builder| builder.serve_at(OBJECT, Chooser)));
    assert_eq!(both(), [true, true], "a portal");
    assert!(shows_dialogs(bus.builder(), None), "a portal, and no search path");
    drop(portal);
    assert!(!shows_dialogs(Builder::address("unix:path=/nowhere/bus"), Some(without.as_os_str())), "no bus");
}
