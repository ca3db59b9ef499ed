//! A verb with arguments as on the command line, and with arrays in place of files.

use std::ffi::OsString;
use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use meshseg::cli::{self, Found, Listener, Memory, Refused};
use meshseg::run::Sample;
use numpy::{IntoPyArray, PyReadonlyArray2};
use pyo3::exceptions::{PyKeyboardInterrupt, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{owned, raised};
use crate::mesh::Mesh;

/// How often signals are looked at.
const BETWEEN_SIGNALS: Duration = Duration::from_millis(50);

/// Calls a verb. `arrays` are those that names of files in the arguments stand for. `callback` is called with each sample:
/// iteration, seconds, energy, bound, relative gap; it ends the run by returning True or by raising.
#[pyfunction]
pub fn call<'py>(
    py: Python<'py>,
    arguments: Vec<OsString>,
    mesh: Option<Py<Mesh>>,
    arrays: Vec<(PathBuf, PyReadonlyArray2<'py, f64>)>,
    callback: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let arrays = arrays.into_iter().map(|(name, array)| (name, owned(&array))).collect();
    let mesh = mesh.map(|mesh| mesh.get().mesh.clone());
    let memory = Memory { mesh, arrays };
    let end = End::default();
    let heard = py.detach(|| interruptible(arguments, memory, &end, callback));
    if let Some(error) = end.take() {
        return Err(error);
    }
    match heard {
        Ok(listener) => of_listener(py, listener),
        Err(Refused::Interrupted) => Err(PyKeyboardInterrupt::new_err(())),
        Err(Refused::Usage(message)) => Err(PyValueError::new_err(message)),
        Err(Refused::Input(error)) => Err(raised(error)),
    }
}

/// Whether the run is to end, and the exception that ends it.
#[derive(Clone, Default)]
struct End {
    is_near: Arc<AtomicBool>,
    error: Arc<Mutex<Option<PyErr>>>,
}

impl End {
    fn raise(&self, error: PyErr) {
        *self.error.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
        self.is_near.store(true, Ordering::Relaxed);
    }

    fn take(&self) -> Option<PyErr> {
        self.error.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    fn flow(&self) -> ControlFlow<()> {
        match self.is_near.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    /// Calls the callback with a sample.
    fn report(&self, callback: &Py<PyAny>, sample: &Sample) {
        let &Sample { iteration, seconds, energy, dual_bound, relative_gap, .. } = sample;
        let arguments = (iteration, seconds, energy, dual_bound, relative_gap);
        match Python::attach(|py| callback.bind(py).call1(arguments)?.is_truthy()) {
            Ok(true) => self.is_near.store(true, Ordering::Relaxed),
            Ok(false) => {}
            Err(error) => self.raise(error),
        }
    }
}

/// Calls a verb in another thread; this one looks at signals, which Python shows to its main thread only.
fn interruptible(
    arguments: Vec<OsString>,
    memory: Memory,
    end: &End,
    callback: Option<Py<PyAny>>,
) -> Result<Listener, Refused> {
    let observer = end.clone();
    let observe = move |sample: Option<&Sample>| {
        if let (Some(sample), Some(callback)) = (sample, &callback) {
            observer.report(callback, sample);
        }
        observer.flow()
    };
    thread::scope(|scope| {
        let (done, is_done) = channel::<()>();
        let verb = scope.spawn(move || {
            let heard = cli::call(arguments, memory, observe);
            // Ends the wait; so does the end of this thread.
            drop(done);
            heard
        });
        while let Err(RecvTimeoutError::Timeout) = is_done.recv_timeout(BETWEEN_SIGNALS) {
            if let Err(signal) = Python::attach(|py| py.check_signals()) {
                end.raise(signal);
            }
        }
        verb.join().unwrap_or_else(|panic| resume_unwind(panic))
    })
}

/// What a verb says and finds.
fn of_listener(py: Python<'_>, listener: Listener) -> PyResult<Bound<'_, PyDict>> {
    let heard = PyDict::new(py);
    heard.set_item("warnings", listener.warnings())?;
    heard.set_item("notes", listener.notes)?;
    heard.set_item("printed", listener.printed)?;
    let Some(Found { summary, solution, vertices, faces }) = listener.found else {
        return Ok(heard);
    };
    heard.set_item("summary", summary)?;
    heard.set_item("labels", vertices.into_pyarray(py))?;
    heard.set_item("face_labels", faces.map(|labels| labels.into_pyarray(py)))?;
    heard.set_item("u", solution.u.into_pyarray(py))?;
    heard.set_item("q", solution.q.map(|q| q.into_pyarray(py)))?;
    heard.set_item("history", history(py, &solution.trace)?)?;
    Ok(heard)
}

/// The trace, a column each.
fn history<'py>(py: Python<'py>, trace: &[Sample]) -> PyResult<Bound<'py, PyDict>> {
    let column = |value: fn(&Sample) -> f64| -> Vec<f64> { trace.iter().map(value).collect() };
    let history = PyDict::new(py);
    let iterations: Vec<i64> = trace.iter().map(|sample| sample.iteration as i64).collect();
    history.set_item("iteration", iterations.into_pyarray(py))?;
    let columns = [
        ("seconds", column(|sample| sample.seconds)),
        ("energy", column(|sample| sample.energy)),
        ("dual_bound", column(|sample| sample.dual_bound)),
        ("gap", column(|sample| sample.gap)),
        ("relative_gap", column(|sample| sample.relative_gap)),
        ("change", column(|sample| sample.change.unwrap_or(f64::NAN))),
    ];
    for (name, numbers) in columns {
        history.set_item(name, numbers.into_pyarray(py))?;
    }
    Ok(history)
}
