//! Errors of the library as exceptions of `barbule.errors`.

use barbule::Error;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The exception of an error: its sentence calls arguments as Python does, and file, line, column and key are attributes.
pub(crate) fn raised(py: Python<'_>, error: &Error) -> PyErr {
    if error.is_interrupted() {
        return PyKeyboardInterrupt::new_err(error.to_string());
    }
    let name = if error.is_input() {
        "InputError"
    } else if error.is_not_settled() {
        "NotSettledError"
    } else {
        "MachineError"
    };
    made(py, name, error).unwrap_or_else(|failed| failed)
}

fn made(py: Python<'_>, name: &str, error: &Error) -> PyResult<PyErr> {
    let about = PyDict::new(py);
    about.set_item("file", error.file().map(|path| path.to_string_lossy().into_owned()))?;
    about.set_item("line", error.line())?;
    about.set_item("column", error.column())?;
    about.set_item("key", error.key())?;
    let message = error.calling(|argument| format!("'{argument}'"));
    let exception = py.import("barbule.errors")?.getattr(name)?.call((message,), Some(&about))?;
    Ok(PyErr::from_value(exception))
}

/// Turns the library's results into Python's.
pub(crate) trait OrRaise<T> {
    /// The value, or the exception.
    fn or_raise(self, py: Python<'_>) -> PyResult<T>;
}

impl<T> OrRaise<T> for barbule::Result<T> {
    fn or_raise(self, py: Python<'_>) -> PyResult<T> {
        self.map_err(|error| raised(py, &error))
    }
}
