//! Open Image Denoise, where the system has it: loaded when a picture asks for it, by its C interface of versions 1 and 2.
#![allow(unsafe_code)] // the functions of a library of C; each call says what it relies on

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::Path;
use std::ptr;

use libloading::Library;

use crate::error::shortened;
use crate::{Error, Result};

/// Its names, the newest first: of Linux, macOS and Windows.
#[cfg(target_os = "macos")]
const NAMES: [&str; 3] = [
    "libOpenImageDenoise.2.dylib",
    "/opt/homebrew/lib/libOpenImageDenoise.dylib",
    "libOpenImageDenoise.dylib",
];
#[cfg(windows)]
const NAMES: [&str; 1] = ["OpenImageDenoise.dll"];
#[cfg(not(any(target_os = "macos", windows)))]
const NAMES: [&str; 4] = [
    "libOpenImageDenoise.so.2",
    "libOpenImageDenoise.so.1",
    "libOpenImageDenoise.so.0",
    "libOpenImageDenoise.so",
];

/// `OIDN_DEVICE_TYPE_CPU`, `OIDN_FORMAT_FLOAT3` and `OIDN_ERROR_NONE` of its header.
const CPU: c_int = 1;
const FLOAT3: c_int = 3;
const NO_ERROR: c_int = 0;

type Handle = *mut c_void;

/// The functions that are called, as the header `oidn.h` declares them. They hold as long as the library, which nobody closes.
#[derive(Clone, Copy)]
struct Functions {
    new_device: unsafe extern "C" fn(c_int) -> Handle,
    set_device_int: unsafe extern "C" fn(Handle, *const c_char, c_int),
    device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    commit_device: unsafe extern "C" fn(Handle),
    release_device: unsafe extern "C" fn(Handle),
    device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    set_image:
        unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize),
    set_filter_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    commit_filter: unsafe extern "C" fn(Handle),
    execute_filter: unsafe extern "C" fn(Handle),
    release_filter: unsafe extern "C" fn(Handle),
}

/// The library, ready to work.
pub struct Denoiser {
    functions: Functions,
    /// Its own numbers: 20301 is version 2.3.1.
    version: c_int,
    /// Closed last.
    _library: Library,
}

/// A picture of three 32-bit numbers a pixel, row by row.
pub type Plane = [[f32; 3]];

/// What the library is given of a picture.
pub struct Noisy<'a> {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Linear light, 0 or more; empty: albedo or normal is the picture that is to be cleaned.
    pub colour: &'a Plane,
    /// Share of light that the first hits scatter, 0 … 1; may be empty.
    pub albedo: &'a Plane,
    /// Their normals, −1 … 1; may be empty.
    pub normal: &'a Plane,
    /// Whether albedo and normal are without noise.
    pub is_clean: bool,
}

impl Denoiser {
    /// Loads the library that the system knows, or the file that is `given`.
    ///
    /// # Errors
    /// It is not there, or is another library: how to install it.
    pub fn load(given: Option<&Path>) -> Result<Self> {
        let library = match given {
            // SAFETY: the user names this file as the library that is to be run; what it does as it is loaded is its own.
            Some(path) => unsafe { Library::new(path) }.map_err(|error| {
                let cause = error.to_string();
                Error::input(format!("cannot be loaded as Open Image Denoise ({})", shortened(&cause)))
                    .in_file(path)
            })?,
            None => NAMES
                .iter()
                // SAFETY: the names are those of Open Image Denoise alone, whose loading runs nothing that depends on this program.
                .find_map(|name| unsafe { Library::new(*name) }.ok())
                .ok_or_else(Self::missing)?,
        };
        let functions = Functions::of(&library).ok_or_else(|| {
            Error::input("the library that is there is no Open Image Denoise of version 1 or 2; give its file (libOpenImageDenoise.so.2) as `denoise`")
                .naming(&["denoise"])
        })?;
        let mut denoiser = Self { functions, version: 0, _library: library };
        let device = Device::new(&functions, 1)?;
        // SAFETY: the device is alive and committed; the name ends in 0.
        denoiser.version = unsafe { (functions.device_int)(device.handle, c"version".as_ptr()) };
        Ok(denoiser)
    }

    /// How it is installed.
    fn missing() -> Error {
        Error::input(format!(
            "Open Image Denoise ({}) is not installed; install it (Debian and Ubuntu: libopenimagedenoise-dev or libopenimagedenoise2, Fedora: oidn, Arch: openimagedenoise, Homebrew: open-image-denoise, else from openimagedenoise.org), or give its file (libOpenImageDenoise.so.2) as `denoise`",
            NAMES[0]
        ))
        .naming(&["denoise"])
    }

    /// Its version, as in 2.3.1.
    #[must_use]
    pub fn version(&self) -> String {
        let v = self.version;
        format!("{}.{}.{}", v / 10000, v / 100 % 100, v % 100)
    }

    /// The picture without its noise, on so many threads.
    ///
    /// # Errors
    /// No plane, planes of other sizes, or what the library says, as that memory ran out.
    pub fn denoise(&self, noisy: &Noisy<'_>, threads: usize) -> Result<Vec<[f32; 3]>> {
        let [width, height] = noisy.size;
        let pixels = width * height;
        let planes = [(c"color", noisy.colour), (c"albedo", noisy.albedo), (c"normal", noisy.normal)];
        let given = || planes.iter().filter(|(_, plane)| !plane.is_empty());
        if given().count() == 0 || given().any(|(_, plane)| plane.len() != pixels) {
            return Err(Error::input(format!(
                "a picture of {width} x {height} needs planes of as many pixels"
            )));
        }
        let mut output = vec![[0.0_f32; 3]; pixels];
        let device = Device::new(&self.functions, threads)?;
        let filter = Filter::new(&device)?;
        given().for_each(|(name, plane)| filter.image(name, plane, noisy.size));
        let functions = &self.functions;
        // SAFETY: filter and names are alive. The library writes `pixels` times three floats to `output` and reads as many from each plane while it
        // runs, which is within this block: `execute` waits until all is done (CPU devices).
        unsafe {
            let target = output.as_mut_ptr().cast();
            let name = c"output".as_ptr();
            (functions.set_image)(filter.handle, name, target, FLOAT3, width, height, 0, 0, 0);
            (functions.set_filter_bool)(filter.handle, c"hdr".as_ptr(), !noisy.colour.is_empty());
            (functions.set_filter_bool)(filter.handle, c"cleanAux".as_ptr(), noisy.is_clean);
            (functions.commit_filter)(filter.handle);
            (functions.execute_filter)(filter.handle);
        }
        device.check()?;
        Ok(output)
    }
}

impl Functions {
    /// Those of the library; none where one is missing.
    fn of(library: &Library) -> Option<Self> {
        /// One of these names, of version 2 or 1.
        ///
        /// # Safety
        /// The function has the type `T`.
        unsafe fn symbol<T: Copy>(library: &Library, names: [&CStr; 2]) -> Option<T> {
            names.iter().find_map(|name| {
                // SAFETY: as the caller promises.
                let found = unsafe { library.get::<T>(name.to_bytes_with_nul()) };
                found.ok().map(|found| *found)
            })
        }
        let same = |name| [name, name];
        // SAFETY: the types are those of the header for these names, in versions 1 and 2 alike.
        unsafe {
            Some(Self {
                new_device: symbol(library, same(c"oidnNewDevice"))?,
                set_device_int: symbol(library, [c"oidnSetDeviceInt", c"oidnSetDevice1i"])?,
                device_int: symbol(library, [c"oidnGetDeviceInt", c"oidnGetDevice1i"])?,
                commit_device: symbol(library, same(c"oidnCommitDevice"))?,
                release_device: symbol(library, same(c"oidnReleaseDevice"))?,
                device_error: symbol(library, same(c"oidnGetDeviceError"))?,
                new_filter: symbol(library, same(c"oidnNewFilter"))?,
                set_image: symbol(library, same(c"oidnSetSharedFilterImage"))?,
                set_filter_bool: symbol(library, [c"oidnSetFilterBool", c"oidnSetFilter1b"])?,
                commit_filter: symbol(library, same(c"oidnCommitFilter"))?,
                execute_filter: symbol(library, same(c"oidnExecuteFilter"))?,
                release_filter: symbol(library, same(c"oidnReleaseFilter"))?,
            })
        }
    }
}

/// A device of the library, released when it goes.
struct Device<'a> {
    functions: &'a Functions,
    handle: Handle,
}

impl<'a> Device<'a> {
    fn new(functions: &'a Functions, threads: usize) -> Result<Self> {
        // SAFETY: takes a number; a device that cannot be made is null, which is asked for next.
        let handle = unsafe { (functions.new_device)(CPU) };
        let device = Self { functions, handle };
        if handle.is_null() {
            return Err(device.failure());
        }
        let threads = c_int::try_from(threads).unwrap_or(c_int::MAX);
        // SAFETY: the device is alive; the name ends in 0.
        unsafe {
            (functions.set_device_int)(handle, c"numThreads".as_ptr(), threads);
            (functions.commit_device)(handle);
        }
        device.check()?;
        Ok(device)
    }

    /// Refuses what went wrong.
    fn check(&self) -> Result<()> {
        // SAFETY: the device is alive; no text is asked for.
        let code = unsafe { (self.functions.device_error)(self.handle, ptr::null_mut()) };
        if code == NO_ERROR {
            Ok(())
        } else {
            Err(Error::machine(format!("Open Image Denoise failed (its error {code})")))
        }
    }

    /// Why there is no device.
    fn failure(&self) -> Error {
        Error::machine("Open Image Denoise makes no device on this processor; render without `denoise`")
            .naming(&["denoise"])
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: made by `new`, released once.
            unsafe { (self.functions.release_device)(self.handle) };
        }
    }
}

/// A filter of a device.
struct Filter<'a> {
    functions: &'a Functions,
    handle: Handle,
}

impl<'a> Filter<'a> {
    fn new(device: &'a Device<'_>) -> Result<Self> {
        // SAFETY: the device is alive; the name ends in 0.
        let handle = unsafe { (device.functions.new_filter)(device.handle, c"RT".as_ptr()) };
        if handle.is_null() {
            device.check()?;
            return Err(device.failure());
        }
        Ok(Self { functions: device.functions, handle })
    }

    /// Gives it a plane, which it only reads.
    fn image(&self, name: &CStr, plane: &Plane, [width, height]: [usize; 2]) {
        // SAFETY: the filter is alive, and the plane outlives it: both are borrowed by `Denoiser::denoise`, which checked that it has width × height
        // pixels. Inputs are not written to.
        unsafe {
            let pixels = plane.as_ptr().cast_mut().cast();
            (self.functions.set_image)(self.handle, name.as_ptr(), pixels, FLOAT3, width, height, 0, 0, 0);
        }
    }
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: made by `new`, released once.
        unsafe { (self.functions.release_filter)(self.handle) };
    }
}
