//! The cache never answers with anything but what was put there under the very key: whatever becomes of
//! its files, and whatever input is changed.

use srp_archdesc::diagnostic::Source;
use srp_archdesc::machines;
use srp_archdesc::watch::{Event, Unwatched, Watch};
use srp_archdesc::{Arch, arch::Srp};
use srp_ir::dfg::Dfg;
use srp_ir::program::Pos;
use srp_scheduler::modulo;
use srp_toolchain::cache::{Cache, Damage, Key, Kind, Place};
use srp_toolchain::{Options, Session, divide, machine, program, schedule_loop};
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Takes down notes.
#[derive(Default)]
struct Notes(Mutex<Vec<String>>);

impl Watch for Notes {
    fn tell(&self, event: Event<'_>) {
        if let Event::Note(note) = event {
            self.0.lock().expect("nobody panics").push(note.to_owned());
        }
    }
}

impl Notes {
    fn taken(&self) -> Vec<String> {
        std::mem::take(&mut self.0.lock().expect("nobody panics"))
    }
}

fn cache_in(folder: &Path) -> Cache {
    Cache::at(Place::Folder(folder.to_owned()))
}

fn key(of: u32) -> Key {
    Key::of(Kind::Trials).value(&of).finish()
}

fn entries(folder: &Path) -> u64 {
    let counts = cache_in(folder)
        .counts(&Unwatched)
        .expect("it has a folder");
    counts.kinds.values().map(|found| found.entries).sum()
}

/// The file of the only entry of a folder.
fn only_file(folder: &Path) -> PathBuf {
    let mut open = vec![folder.to_owned()];
    let mut files = Vec::new();
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).expect("it can be read").flatten() {
            match entry.path() {
                path if path.is_dir() => open.push(path),
                path => files.push(path),
            }
        }
    }
    assert_eq!(files.len(), 1, "{files:?}");
    files.remove(0)
}

#[test]
fn damage_is_noticed_and_mended() {
    let folder = tempfile::tempdir().expect("a folder");
    let value = "what was put there".repeat(8);
    cache_in(folder.path()).put(key(1), &value, &Unwatched);
    let file = only_file(folder.path());
    let whole = fs::read(&file).expect("it can be read");
    let truncated = (0..whole.len()).map(|n| whole[..n].to_vec());
    let flipped = (0..whole.len()).map(|n| {
        let mut bytes = whole.clone();
        bytes[n] ^= 0x10;
        bytes
    });
    let longer = [[&whole[..], b"x"].concat(), [b"x", &whole[..]].concat()];
    for damaged in truncated.chain(flipped).chain(longer) {
        fs::write(&file, &damaged).expect("it can be written");
        let (notes, cache) = (Notes::default(), cache_in(folder.path()));
        assert_eq!(cache.get::<String>(key(1), &notes), None);
        let said = notes.taken();
        assert!(
            matches!(&said[..], [note] if note.contains("damaged")),
            "{said:?}"
        );
        assert!(!file.exists(), "a damaged entry stays");
        cache.put(key(1), &value, &notes);
        assert_eq!(fs::read(&file).expect("it is back"), whole);
        let known = cache_in(folder.path()).get::<String>(key(1), &notes);
        assert_eq!(known.as_deref(), Some(value.as_str()));
        assert_eq!(notes.taken(), Vec::<String>::new());
    }
}

#[test]
fn an_entry_of_another_key_is_not_taken() {
    let folder = tempfile::tempdir().expect("a folder");
    let cache = cache_in(folder.path());
    cache.put(key(1), &"one", &Unwatched);
    let one = only_file(folder.path());
    let name = key(2).to_string();
    let two = folder
        .path()
        .join(one.strip_prefix(folder.path()).expect("it is inside"));
    let two = two.parent().and_then(Path::parent).expect("a kind");
    let two = two.join(&name[..2]).join(&name);
    fs::create_dir_all(two.parent().expect("a folder")).expect("it can be made");
    fs::copy(&one, &two).expect("it can be copied");
    let notes = Notes::default();
    assert_eq!(cache_in(folder.path()).get::<String>(key(2), &notes), None);
    assert_eq!(notes.taken().len(), 1);
    fs::copy(&one, &two).expect("it can be copied");
    let (whole, damaged) = (cache_in(folder.path()).verify(&Unwatched)).expect("it has a folder");
    assert_eq!(whole.entries, 1);
    assert_eq!(damaged, vec![(two, Damage::Key)]);
    let known = cache_in(folder.path()).get::<String>(key(1), &notes);
    assert_eq!(known.as_deref(), Some("one"));
}

#[test]
fn folders_that_others_may_write_to_are_not_used() {
    let folder = tempfile::tempdir().expect("a folder");
    cache_in(folder.path()).put(key(1), &"planted", &Unwatched);
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o777)).expect("it is ours");
    let (notes, cache) = (Notes::default(), cache_in(folder.path()));
    assert_eq!(cache.get::<String>(key(1), &notes), None);
    assert!(notes.taken()[0].contains("other users may write to it"));
    cache.put(key(1), &"own", &notes);
    assert_eq!(cache.get::<String>(key(1), &notes).as_deref(), Some("own"));
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o700)).expect("it is ours");
    let known = cache_in(folder.path()).get::<String>(key(1), &notes);
    assert_eq!(known.as_deref(), Some("planted"), "it was left alone");
}

#[test]
fn without_a_folder_work_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    fs::write(&file, "not a folder").expect("it can be written");
    for place in [file.join("cache"), PathBuf::from("/proc/no/such/place")] {
        let (notes, cache) = (Notes::default(), Cache::at(Place::Folder(place)));
        cache.put(key(1), &"value", &notes);
        assert_eq!(
            cache.get::<String>(key(1), &notes).as_deref(),
            Some("value")
        );
        assert_eq!(notes.taken().len(), 1, "one note, and no more");
        assert!(cache.workplace(&notes).is_ok());
    }
    let cache = Cache::at(Place::Temporary);
    cache.put(key(1), &"value", &Unwatched);
    let place = cache.counts(&Unwatched).expect("a folder").folder;
    let mode = fs::metadata(&place)
        .expect("it is there")
        .permissions()
        .mode();
    assert_eq!(mode & 0o777, 0o700, "nobody else may look");
    drop(cache);
    assert!(!place.exists(), "a temporary folder goes with the process");
}

/// A loop, and a machine.
fn some_loop() -> (Dfg, Arch) {
    let arch = machine::read(Path::new("sgrt")).expect("it comes along");
    let options = Options::default();
    let text = "float a[64], b[64]; int main(void) { float s = 0; for (int i = 0; i < 64; i++) { \
                b[i] = a[i] * 3; s += a[i]; } return s > 7; }";
    let sources = vec![Source::new("some.c", text)];
    let compiled = program(srp_toolchain::Input::C(sources), &arch, &options);
    let (mut program, _) = compiled.expect("it is right");
    let divided = divide(&mut program, &arch).expect("it fits");
    let smallest = (divided.dre.kernels.values()).min_by_key(|dfg| dfg.nodes.len());
    (smallest.expect("it has loops").clone(), arch)
}

#[test]
fn every_input_of_a_schedule_is_in_its_key() {
    let (dfg, arch) = some_loop();
    let options = modulo::Options {
        effort: 1000,
        ..modulo::Options::default()
    };
    let folder = tempfile::tempdir().expect("a folder");
    let schedule = |dfg: &Dfg, srp: &Srp, options: &modulo::Options| {
        let session = Session::default().with_cache(cache_in(folder.path()));
        let before = entries(folder.path());
        let result = schedule_loop(dfg, srp, options, &session, &Unwatched);
        (result, entries(folder.path()) - before)
    };
    let (first, added) = schedule(&dfg, &arch.srp, &options);
    assert_eq!(added, 1);
    let first = first.expect("it has a schedule");

    // What a schedule does not depend on finds it again, with names and places of its own.
    let mut moved = dfg.clone();
    moved.name = "another".to_owned();
    let nodes: Vec<_> = moved.nodes.keys().collect();
    for &node in &nodes {
        moved.nodes[node].pos = Pos::nowhere();
    }
    let (again, added) = schedule(&moved, &arch.srp, &options);
    assert_eq!(added, 0, "positions are not an input");
    let again = again.expect("it has a schedule");
    assert_eq!(again.schedule.dfg, moved);
    assert_eq!(again.schedule.ops, first.schedule.ops);
    let mut other = arch.clone();
    other.system.srp_mhz += 1;
    other.system.dram.latency_ns += 1;
    assert_eq!(
        schedule(&dfg, &other.srp, &options).1,
        0,
        "nor is the system"
    );

    let mut graphs = Vec::new();
    let mut changed = dfg.clone();
    changed.trip = Some(changed.trip.map_or(7, |trip| trip + 1));
    graphs.push(changed);
    if !dfg.live_outs.is_empty() {
        let mut changed = dfg.clone();
        changed.live_outs.clear();
        graphs.push(changed);
    }
    for &node in &nodes {
        let mut changed = dfg.clone();
        changed.nodes[node].imm ^= 1;
        graphs.push(changed);
    }
    if !dfg.order.is_empty() {
        let mut changed = dfg.clone();
        changed.order[0].distance += 1;
        graphs.push(changed);
    }
    for changed in graphs {
        assert_eq!(schedule(&changed, &arch.srp, &options).1, 1, "a graph");
    }

    for changed in machines_one_edit_away() {
        assert_eq!(schedule(&dfg, &changed, &options).1, 1, "a machine");
    }

    let mut changed = options;
    changed.effort += 1;
    assert_eq!(schedule(&dfg, &arch.srp, &changed).1, 1, "an option");
}

/// The array of `sgrt` with each number of it changed in turn, as it stands in the machine's file.
fn machines_one_edit_away() -> Vec<Srp> {
    let text = machines::ALL
        .iter()
        .find(|m| m.name == "sgrt")
        .expect("it comes along")
        .xml;
    let array = text.find("<array").expect("it has one")..text.find("</array>").expect("it ends");
    let original = machine::parse("sgrt.xml", text).expect("it is right").srp;
    let mut found = Vec::new();
    let mut at = array.start;
    while let Some(quote) = text[at..array.end].find('"') {
        let start = at + quote + 1;
        let end = start + text[start..].find('"').expect("it is closed");
        at = end + 1;
        let Ok(number) = text[start..end].parse::<u32>() else {
            continue;
        };
        let edited = format!("{}{}{}", &text[..start], number + 1, &text[end..]);
        // Some numbers cannot be any other.
        if let Ok(arch) = machine::parse("sgrt.xml", &edited)
            && arch.srp != original
        {
            found.push(arch.srp);
        }
    }
    assert!(
        found.len() > 5,
        "the machine has more numbers than {}",
        found.len()
    );
    found
}
