//! Names the build: digests over the sources of the tools, so that what another build has kept is not
//! taken for this one's, whatever the files' times and the version's number.

use std::path::{Path, PathBuf};

/// The crates that a schedule of a loop depends on.
const SCHEDULER: [&str; 3] = ["archdesc", "ir", "scheduler"];

/// All crates whose code or data a result may depend on.
const ALL: [&str; 9] = [
    "archdesc",
    "csimgen",
    "frontend",
    "ir",
    "kernels",
    "runtime",
    "scheduler",
    "studies",
    "toolchain",
];

fn main() {
    let toolchain = std::env::var("CARGO_MANIFEST_DIR").expect("cargo names the crate's folder");
    let root = Path::new(&toolchain).join("..");
    println!(
        "cargo::rustc-env=SRP_SCHEDULER_ID={}",
        digest(&root, &SCHEDULER)
    );
    println!("cargo::rustc-env=SRP_BUILD_ID={}", digest(&root, &ALL));
}

/// A digest over the lock file and the sources of some crates.
fn digest(root: &Path, crates: &[&str]) -> String {
    let mut files = vec![root.join("Cargo.lock")];
    for name in crates {
        files.push(root.join(name).join("Cargo.toml"));
        for folder in ["src", "machines", "libc"] {
            collect(&root.join(name).join(folder), &mut files);
        }
        if *name == "kernels" {
            collect_files(&root.join(name), &mut files);
        }
    }
    files.sort();
    let mut hasher = blake3::Hasher::new();
    for file in files {
        println!("cargo::rerun-if-changed={}", file.display());
        let name = file.strip_prefix(root).unwrap_or(&file);
        hasher.update(name.as_os_str().as_encoded_bytes());
        let text = std::fs::read(&file).unwrap_or_default();
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(&text);
    }
    hasher.finalize().to_hex().to_string()
}

/// All files below a folder.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    // A folder's time changes with the names in it.
    println!("cargo::rerun-if-changed={}", folder.display());
    for path in entries.flatten().map(|entry| entry.path()) {
        match path.is_dir() {
            true => collect(&path, files),
            false => files.push(path),
        }
    }
}

/// The files of a folder itself.
fn collect_files(folder: &Path, files: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    println!("cargo::rerun-if-changed={}", folder.display());
    files.extend(
        entries
            .map(|entry| entry.path())
            .filter(|path| path.is_file()),
    );
}
