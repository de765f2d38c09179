//! Headers in lines of text, before binary data or alone.

use super::Error;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// No header is longer.
const LONGEST: u64 = 1 << 20;

/// Lines of a header, and the byte after each.
pub struct Lines {
    reader: BufReader<std::io::Take<std::fs::File>>,
    file: PathBuf,
    /// Byte after the last line given.
    pub offset: u64,
}

impl Lines {
    pub fn of(file: &Path) -> Result<Self, Error> {
        let opened = std::fs::File::open(file).map_err(|e| Error::io(file, &e))?;
        Ok(Lines { reader: BufReader::new(opened.take(LONGEST)), file: file.to_owned(), offset: 0 })
    }

    /// The next line without its end; `None` at the end of the file.
    pub fn next(&mut self) -> Result<Option<String>, Error> {
        let mut bytes = Vec::new();
        let read = self.reader.read_until(b'\n', &mut bytes).map_err(|e| Error::io(&self.file, &e))?;
        self.offset += read as u64;
        if read == 0 {
            return Ok(None);
        }
        if self.offset >= LONGEST {
            let what = "the header does not end within 1 MiB";
            return Err(Error::new(&self.file, what, "this is another kind of file"));
        }
        while bytes.last().is_some_and(|b| matches!(b, b'\n' | b'\r')) {
            bytes.pop();
        }
        Ok(Some(String::from_utf8_lossy(&bytes).into_owned()))
    }
}

/// Three positive whole numbers.
pub fn three(file: &Path, name: &str, text: &str) -> Result<[u64; 3], Error> {
    let numbers: Vec<u64> = text.split_whitespace().filter_map(|w| w.parse().ok()).collect();
    match numbers[..] {
        [x, y, z] if text.split_whitespace().count() == 3 => Ok([x, y, z]),
        _ => Err(Error::new(
            file,
            format!("`{name}` is `{text}`"),
            "a volume has three dimensions: x, y and slices; drop others (time, colour)",
        )),
    }
}

/// A file named in a header, in the header's folder.
pub fn beside(file: &Path, name: &str) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(name)
}
