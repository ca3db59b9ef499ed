//! Who called a verb: a shell, or a program in the same process, such as Python.
//!
//! A shell reads standard output and standard error. A program listens: it gets what the verb prints, what it warns of
//! and what it finds, sees every sample, and can end the run.

use std::cell::RefCell;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};

use ndarray::Array1;

use crate::run::Sample;
use crate::solve::Solution;
use crate::{Result, sweep};

/// What a verb finds, on the vertices and faces of the file.
pub struct Found {
    /// `summary.json`.
    pub summary: String,
    /// Energies, bounds and U, on the vertices or faces that are labeled.
    pub solution: Solution,
    /// V labels.
    pub vertices: Array1<i32>,
    /// F labels, if there are any.
    pub faces: Option<Array1<i32>>,
}

type Observe = Box<dyn FnMut(Option<&Sample>) -> ControlFlow<()> + Send>;

/// A program that listens to a verb.
pub struct Listener {
    /// What is printed to standard output in a shell.
    pub printed: String,
    /// What is said on standard error, without warnings.
    pub notes: Vec<String>,
    /// The result of `segment` and `solve`.
    pub found: Option<Found>,
    /// Called between the passes of a solver, with a sample where one was taken; may end the run.
    pub observe: Observe,
    warnings: Lines,
}

thread_local! {
    static LISTENER: RefCell<Option<Listener>> = const { RefCell::new(None) };
}

/// Lines of the log.
#[derive(Clone, Default)]
struct Lines(Arc<Mutex<Vec<u8>>>);

impl Write for Lines {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Listener {
    /// A listener who has heard nothing.
    pub fn new(observe: impl FnMut(Option<&Sample>) -> ControlFlow<()> + Send + 'static) -> Self {
        Listener {
            printed: String::new(),
            notes: Vec::new(),
            found: None,
            observe: Box::new(observe),
            warnings: Lines::default(),
        }
    }

    /// The warnings so far, a sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let bytes = self.warnings.0.lock().unwrap_or_else(PoisonError::into_inner);
        String::from_utf8_lossy(&bytes).lines().map(|line| line.trim_start().to_owned()).collect()
    }

    /// Calls a verb, to which the listener listens in this thread.
    pub fn hear<T>(self, verb: impl FnOnce() -> T) -> (T, Self) {
        let warnings = self.warnings.clone();
        let log = tracing_subscriber::fmt()
            .with_writer(move || warnings.clone())
            .with_target(false)
            .with_level(false)
            .without_time()
            .with_ansi(false)
            .finish();
        LISTENER.set(Some(self));
        let result = tracing::subscriber::with_default(log, verb);
        (result, LISTENER.take().expect("no one else takes it"))
    }
}

/// Calls a function with the listener, if there is one.
pub fn listening<T>(call: impl FnOnce(&mut Listener) -> T) -> Option<T> {
    LISTENER.with_borrow_mut(|listener| listener.as_mut().map(call))
}

/// [`sweep::with_threads`] for a verb, whose listener goes with it.
pub fn with_threads<T: Send>(threads: Option<usize>, verb: impl FnOnce() -> T + Send) -> Result<T> {
    let Some(listener) = LISTENER.take() else { return sweep::with_threads(threads, verb) };
    let mut listener = Some(listener);
    let result = sweep::with_threads(threads, || {
        let (result, heard) = listener.take().expect("it is called once").hear(verb);
        listener = Some(heard);
        result
    });
    LISTENER.set(listener);
    result
}
