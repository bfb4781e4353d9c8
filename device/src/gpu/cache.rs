//! Compiled pipelines kept in a file between runs, where the device offers it. A cache only ever saves time: whatever is
//! wrong with the file, it is ignored and written anew.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// What a file begins with; another layout gets another number.
const MAGIC: &[u8; 8] = b"PATINA01";
/// Larger files are started anew: nothing else ever makes them smaller.
const MAX_BYTES: u64 = 64 << 20;

/// The pipelines of one device.
#[derive(Debug)]
pub(super) struct DiskCache {
    pub(super) cache: wgpu::PipelineCache,
    path: PathBuf,
    /// Checksum of what the file holds.
    on_disk: AtomicU64,
}

impl DiskCache {
    /// Opens the cache of a device in a folder, which need not exist yet. None where the device has no such thing.
    pub(super) fn open(
        device: &wgpu::Device,
        info: &wgpu::AdapterInfo,
        folder: &Path,
    ) -> Option<Self> {
        if !device.features().contains(wgpu::Features::PIPELINE_CACHE) {
            return None;
        }
        // wgpu's key tells devices apart; drivers must not see each other's either.
        let driver = format!("{} {} {}", info.name, info.driver, info.driver_info);
        let key = wgpu::util::pipeline_cache_key(info)?;
        let path = folder.join(format!("{key}_{:016x}.bin", fnv1a(driver.as_bytes())));
        let data = read(&path);
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        // SAFETY: the data is what `get_data` gave for this adapter and driver, by the file's name, and as it was
        // written, by its checksum; wgpu and the driver check their own headers besides.
        let cache = unsafe {
            device.create_pipeline_cache(&wgpu::PipelineCacheDescriptor {
                label: Some("pipelines"),
                data: data.as_deref(),
                fallback: true,
            })
        };
        if pollster::block_on(scope.pop()).is_some() {
            return None;
        }
        Some(Self {
            cache,
            path,
            on_disk: AtomicU64::new(data.map_or(0, |data| fnv1a(&data))),
        })
    }

    /// Writes the pipelines that have been compiled so far, if they are not in the file yet.
    pub(super) fn save(&self) -> io::Result<()> {
        let Some(data) = self.cache.get_data() else {
            return Ok(());
        };
        let sum = fnv1a(&data);
        if self.on_disk.load(Ordering::Relaxed) == sum {
            return Ok(());
        }
        write(&self.path, &data)?;
        self.on_disk.store(sum, Ordering::Relaxed);
        Ok(())
    }
}

/// The data of a file that is whole; None for any other.
fn read(path: &Path) -> Option<Vec<u8>> {
    if std::fs::metadata(path).ok()?.len() > MAX_BYTES {
        return None;
    }
    let file = std::fs::read(path).ok()?;
    let (head, data) = file.split_at_checked(16)?;
    let (magic, sum) = head.split_at(8);
    (magic == MAGIC && sum == fnv1a(data).to_le_bytes()).then(|| data.to_vec())
}

/// Writes aside and renames, so that no reader ever sees half a file.
fn write(path: &Path, data: &[u8]) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let aside = path.with_extension(format!("{}.new", std::process::id()));
    let mut file = MAGIC.to_vec();
    file.extend(fnv1a(data).to_le_bytes());
    file.extend(data);
    let written = std::fs::write(&aside, file).and_then(|()| std::fs::rename(&aside, path));
    if written.is_err() {
        let _ = std::fs::remove_file(&aside);
    }
    written
}

/// FNV-1a (Fowler, Noll, Vo), 64 bits: tells texts apart in the same way on every machine.
pub fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_as_it_was_written_or_not_at_all() {
        let folder = std::env::temp_dir().join(format!("patina-cache-{}", std::process::id()));
        let path = folder.join("below").join("a.bin");
        assert_eq!(read(&path), None, "absent");
        write(&path, b"pipelines").expect("written");
        assert_eq!(read(&path).as_deref(), Some(&b"pipelines"[..]));
        let whole = std::fs::read(&path).expect("there");
        for broken in [
            &whole[..0],
            &whole[..10],
            &whole[..whole.len() - 1],
            &[&whole[..], b"x"].concat(),
            &[b"X", &whole[1..]].concat(),
        ] {
            std::fs::write(&path, broken).expect("written");
            assert_eq!(read(&path), None, "{broken:?}");
        }
        write(&path, b"").expect("replaced");
        assert_eq!(read(&path).as_deref(), Some(&b""[..]));
        let files = std::fs::read_dir(folder.join("below")).expect("there");
        assert_eq!(files.count(), 1, "nothing is left beside it");
        let _ = std::fs::remove_dir_all(&folder);
    }

    #[test]
    fn the_checksum_is_fnv1a() {
        // From the reference's test vectors.
        assert_eq!(fnv1a(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a(b"foobar"), 0x8594_4171_f739_67e8);
    }
}
