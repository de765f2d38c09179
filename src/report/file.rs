//! Files that are either whole or absent, also after a crash or a power cut.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes `bytes` to `path` durably and at once: to a file beside it, synced, renamed over `path`,
/// folder synced. A reader sees the old content or the new, never a part.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let name = path.file_name().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "no file name"))?;
    let mut beside = std::ffi::OsString::from(".");
    beside.push(name);
    beside.push(format!(".{}.part", std::process::id()));
    let beside = folder.join(beside);
    let written = File::create(&beside).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    let done = written.and_then(|()| fs::rename(&beside, path));
    if done.is_err() {
        // Leave no debris; the first error is the one worth telling.
        let _ = fs::remove_file(&beside);
    }
    done.and_then(|()| sync_folder(folder))
}

/// Makes a rename in `folder` survive a power cut.
#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}
/// Folders cannot be synced here; the rename itself is atomic.
#[cfg(not(unix))]
fn sync_folder(_folder: &Path) -> io::Result<()> {
    Ok(())
}

/// The folder of one run.
#[derive(Clone, Debug)]
pub struct RunFolder {
    path: PathBuf,
}

impl RunFolder {
    /// Creates the folder `path` with all its parents and checks that it can be written, before
    /// any history is spent. A folder that already holds something is refused
    /// (`AlreadyExists`) unless `force`, which replaces files of the same names and leaves others.
    pub fn create(path: &Path, force: bool) -> io::Result<RunFolder> {
        fs::create_dir_all(path)?;
        if !force && fs::read_dir(path)?.next().is_some() {
            let text = format!("{} is not empty; --force writes into it all the same", path.display());
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, text));
        }
        let probe = path.join(format!(".probe.{}", std::process::id()));
        OpenOptions::new().write(true).create(true).truncate(true).open(&probe)?;
        fs::remove_file(&probe)?;
        Ok(RunFolder { path: path.to_owned() })
    }
    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }
    /// Writes the file `name` into the folder, see [`write_atomic`].
    pub fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        write_atomic(&self.path.join(name), bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_replaced_whole_and_leave_nothing_beside() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("result.json");
        write_atomic(&path, b"one").unwrap();
        write_atomic(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
        assert!(write_atomic(&dir.path().join("missing/x"), b"").is_err());
    }

    #[test]
    fn a_used_folder_needs_force() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a/b");
        RunFolder::create(&path, false).unwrap().write("x.csv", b"1").unwrap();
        assert_eq!(RunFolder::create(&path, false).unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        RunFolder::create(&path, true).unwrap().write("y.csv", b"2").unwrap();
        assert_eq!(fs::read_dir(&path).unwrap().count(), 2);
    }
}
