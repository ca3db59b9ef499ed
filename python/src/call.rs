//! A verb with arguments as on the command line, and with arrays in place of files.

use std::ffi::OsString;
use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
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

/// Calls a verb. `arrays` are those that names of files in the arguments stand for. `callback` is called by this thread
/// with samples: iteration, seconds, energy, bound, relative gap; it ends the run by returning True or by raising.
/// What is wrong with the input is an exception that is returned under `error`, not raised, unlike those of callbacks
/// and signals.
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
    let (heard, error) = py.detach(|| interruptible(arguments, memory, callback.as_ref()));
    if let Some(error) = error {
        return Err(error);
    }
    let refused = match heard {
        Ok(listener) => return of_listener(py, listener),
        Err(Refused::Interrupted) => return Err(PyKeyboardInterrupt::new_err(())),
        Err(Refused::Usage(message)) => PyValueError::new_err(message),
        Err(Refused::Input(error)) => raised(error),
    };
    let found = PyDict::new(py);
    found.set_item("error", refused.into_value(py))?;
    Ok(found)
}

/// A sample, and where to answer whether the run is to end.
type Question = (Sample, Sender<bool>);

/// Calls a verb in another thread. This one calls the callback and looks at signals, which Python shows to its main
/// thread only; the first exception of either ends the run.
fn interruptible(
    arguments: Vec<OsString>,
    memory: Memory,
    callback: Option<&Py<PyAny>>,
) -> (Result<Listener, Refused>, Option<PyErr>) {
    let is_over = Arc::new(AtomicBool::new(false));
    let (ask, questions) = channel::<Question>();
    let asks = callback.is_some();
    let observe = {
        let is_over = is_over.clone();
        move |sample: Option<&Sample>| {
            if let Some(&sample) = sample.filter(|_| asks) {
                let (answer, answers) = channel();
                let ends = ask.send((sample, answer)).is_ok() && answers.recv().unwrap_or(true);
                is_over.fetch_or(ends, Ordering::Relaxed);
            }
            match is_over.load(Ordering::Relaxed) {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        }
    };
    thread::scope(|scope| {
        let verb = scope.spawn(move || {
            cli::call(arguments, memory, observe).map(|mut listener| {
                // The channel closes with its other end, which the observer holds.
                listener.observe = Box::new(|_| ControlFlow::Continue(()));
                listener
            })
        });
        let mut error = None;
        loop {
            let outcome = match questions.recv_timeout(BETWEEN_SIGNALS) {
                Ok((sample, answer)) => {
                    let outcome = match (callback, &error) {
                        (Some(callback), None) => report(callback, &sample),
                        _ => Ok(true),
                    };
                    // Nobody waits for the answer of a run that has ended.
                    let _ = answer.send(*outcome.as_ref().unwrap_or(&true));
                    outcome.map(drop)
                }
                Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals()),
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if let Err(first) = outcome {
                is_over.store(true, Ordering::Relaxed);
                error.get_or_insert(first);
            }
        }
        (verb.join().unwrap_or_else(|panic| resume_unwind(panic)), error)
    })
}

/// Whether the callback ends the run at a sample.
fn report(callback: &Py<PyAny>, sample: &Sample) -> PyResult<bool> {
    let &Sample { iteration, seconds, energy, dual_bound, relative_gap, .. } = sample;
    let arguments = (iteration, seconds, energy, dual_bound, relative_gap);
    Python::attach(|py| callback.bind(py).call1(arguments)?.is_truthy())
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
