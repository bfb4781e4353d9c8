//! The C interface of Open Image Denoise 2 (its `oidn.h`): the few functions that are needed, found by their names in a library
//! that is opened at run time. Everything unsafe about it is here.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::mem::ManuallyDrop;
use std::path::Path;
use std::ptr;

/// What the system calls the library.
pub const FILE: &str = if cfg!(windows) {
    "OpenImageDenoise.dll"
} else if cfg!(target_vendor = "apple") {
    "libOpenImageDenoise.2.dylib"
} else {
    "libOpenImageDenoise.so.2"
};

/// `OIDN_DEVICE_TYPE_CPU`: GPUs give other last bits.
const PROCESSOR: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;
/// `OIDN_ERROR_NONE`.
const NO_ERROR: c_int = 0;
/// The one filter for rendered pictures.
const RAY_TRACED: &CStr = c"RT";
const OUTPUT: &CStr = c"output";

/// An image that a filter reads, by its name there.
pub(super) type Image<'a> = (&'a CStr, &'a [[f32; 3]]);

type Device = *mut c_void;
type Filter = *mut c_void;

/// Declares the functions, and finds them.
macro_rules! functions {
    ($($field:ident = $symbol:literal: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        #[derive(Debug)]
        struct Functions {
            $($field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            /// # Safety
            /// What the library has by these names are functions of these types.
            unsafe fn find(library: &libloading::Library) -> Result<Self, libloading::Error> {
                Ok(Self {
                    // SAFETY: as the caller promises.
                    $($field: *unsafe { library.get($symbol) }?,)*
                })
            }
        }
    };
}

functions! {
    new_device = b"oidnNewDevice\0": fn(c_int) -> Device;
    release_device = b"oidnReleaseDevice\0": fn(Device);
    set_device_bool = b"oidnSetDeviceBool\0": fn(Device, *const c_char, bool);
    set_device_int = b"oidnSetDeviceInt\0": fn(Device, *const c_char, c_int);
    get_device_int = b"oidnGetDeviceInt\0": fn(Device, *const c_char) -> c_int;
    commit_device = b"oidnCommitDevice\0": fn(Device);
    get_error = b"oidnGetDeviceError\0": fn(Device, *mut *const c_char) -> c_int;
    new_filter = b"oidnNewFilter\0": fn(Device, *const c_char) -> Filter;
    release_filter = b"oidnReleaseFilter\0": fn(Filter);
    // Filter, name, pixels, format, width, height, offset, bytes from pixel to pixel and from row to row (0: none between).
    set_image = b"oidnSetSharedFilterImage\0": fn(Filter, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);
    set_filter_bool = b"oidnSetFilterBool\0": fn(Filter, *const c_char, bool);
    commit_filter = b"oidnCommitFilter\0": fn(Filter);
    execute_filter = b"oidnExecuteFilter\0": fn(Filter);
}

/// The library with a device of its own: the processor.
#[derive(Debug)]
pub(super) struct Library {
    functions: Functions,
    device: Device,
    /// It is never closed: threads that it has started may still be in it.
    _library: ManuallyDrop<libloading::Library>,
}

impl Library {
    /// Opens it, with a number of threads to compute with.
    pub(super) fn open(path: &Path, threads: usize) -> Result<Self, String> {
        // SAFETY: what a library does when it is opened is its own business; the user has named or installed it.
        let library = unsafe { open(path) }.map_err(|error| told(&error))?;
        let library = ManuallyDrop::new(library);
        // SAFETY: functions that have these names are those of `oidn.h`, whose types they are declared with; version 2 has not changed
        // them since 2.0. The version is checked before anything else is made of them.
        let functions = unsafe { Functions::find(&library) }
            .map_err(|error| format!("it isn't Open Image Denoise 2 ({})", told(&error)))?;
        // SAFETY: a device of this type may be asked for anywhere; where it can't be made, the answer is null.
        let device = unsafe { (functions.new_device)(PROCESSOR) };
        let library = Self {
            functions,
            device,
            _library: library,
        };
        if device.is_null() {
            let reason = library.error().unwrap_or_default();
            return Err(format!("it can't compute on this processor: {reason}"));
        }
        let threads = c_int::try_from(threads).unwrap_or(c_int::MAX);
        // SAFETY: the device is one, and has not been committed; the names are texts that C takes.
        unsafe {
            let functions = &library.functions;
            (functions.set_device_int)(device, c"numThreads".as_ptr(), threads);
            // The others of this process are not to be crowded together.
            (functions.set_device_bool)(device, c"setAffinity".as_ptr(), false);
            (functions.commit_device)(device);
        }
        match library.error() {
            None => Ok(library),
            Some(reason) => Err(reason),
        }
    }

    /// Major, minor, patch.
    pub(super) fn version(&self) -> [i32; 3] {
        [c"versionMajor", c"versionMinor", c"versionPatch"].map(|name| {
            // SAFETY: the device is one, the name a text that C takes.
            unsafe { (self.functions.get_device_int)(self.device, name.as_ptr()) }
        })
    }

    /// What the filter makes of images, all of the same size; flags are parameters of it that are set.
    ///
    /// # Panics
    /// An image has other than width times height pixels.
    pub(super) fn filter(
        &self,
        [width, height]: [usize; 2],
        images: &[Image<'_>],
        flags: &[&CStr],
    ) -> Result<Vec<[f32; 3]>, String> {
        let is_whole = |(_, pixels): &Image<'_>| pixels.len() == width * height;
        assert!(
            images.iter().all(is_whole),
            "images have width times height pixels"
        );
        let mut output = vec![[0.0; 3]; width * height];
        let functions = &self.functions;
        // SAFETY: the device is one. Where there is no filter the answer is null, which all functions below take and complain of.
        let filter = unsafe { (functions.new_filter)(self.device, RAY_TRACED.as_ptr()) };
        // SAFETY: every image is as large as is said, three floats a pixel without gaps, and is there until the filter has been
        // released, at the end of this block. Inputs are only read, whatever the type of their pointers says, and the output is in
        // none of them. A filter on the processor is executed before the function returns.
        unsafe {
            let set = |name: &CStr, pixels: *mut c_void| {
                let name = name.as_ptr();
                (functions.set_image)(filter, name, pixels, FLOAT3, width, height, 0, 0, 0);
            };
            for (name, pixels) in images {
                set(name, pixels.as_ptr().cast_mut().cast());
            }
            set(OUTPUT, output.as_mut_ptr().cast());
            for flag in flags {
                (functions.set_filter_bool)(filter, flag.as_ptr(), true);
            }
            (functions.commit_filter)(filter);
            (functions.execute_filter)(filter);
            (functions.release_filter)(filter);
        }
        match self.error() {
            None => Ok(output),
            Some(reason) => Err(reason),
        }
    }

    /// What has gone wrong first since this was asked last.
    fn error(&self) -> Option<String> {
        let mut message = ptr::null();
        // SAFETY: the device is one, or null, which stands for devices that could not be made; the place takes a pointer.
        let code = unsafe { (self.functions.get_error)(self.device, &raw mut message) };
        if code == NO_ERROR {
            return None;
        }
        if message.is_null() {
            return Some(format!("error {code}"));
        }
        // SAFETY: it is a text that ends with a zero, and is there until the next call.
        let message = unsafe { CStr::from_ptr(message) };
        Some(message.to_string_lossy().into_owned())
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        if !self.device.is_null() {
            // SAFETY: the device is one, and nobody has it any more.
            unsafe { (self.functions.release_device)(self.device) }
        }
    }
}

/// # Safety
/// As [`libloading::Library::new`].
#[cfg(not(windows))]
unsafe fn open(path: &Path) -> Result<libloading::Library, libloading::Error> {
    // SAFETY: as the caller promises.
    unsafe { libloading::Library::new(path) }
}

/// As above; the libraries that it needs lie beside it.
///
/// # Safety
/// As [`libloading::Library::new`].
#[cfg(windows)]
unsafe fn open(path: &Path) -> Result<libloading::Library, libloading::Error> {
    use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};

    let flags = match path.is_absolute() {
        true => LOAD_WITH_ALTERED_SEARCH_PATH,
        false => 0,
    };
    // SAFETY: as the caller promises.
    unsafe { Library::load_with_flags(path, flags) }.map(Into::into)
}

/// What the system says, in one line.
fn told(error: &libloading::Error) -> String {
    let source = std::error::Error::source(error);
    source.map_or_else(|| error.to_string(), ToString::to_string)
}
