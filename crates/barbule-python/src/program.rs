//! The command line in the wheel.

use pyo3::prelude::*;

/// Runs one command line, `arguments` with the program's name first, and returns its exit code. Ctrl-C is the program's own.
#[pyfunction]
pub(crate) fn run(py: Python<'_>, arguments: Vec<String>) -> PyResult<u8> {
    // Python's own handler would keep the signal until the program ends; the program sets its own where it can stop well.
    let signal = py.import("signal")?;
    signal.call_method1("signal", (signal.getattr("SIGINT")?, signal.getattr("SIG_DFL")?))?;
    Ok(py.detach(|| barbule_cli::program(arguments.into_iter().map(Into::into).collect())))
}

/// The version of the library.
#[pyfunction]
pub(crate) fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}
