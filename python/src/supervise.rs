//! Long work beside the interpreter: it runs on a thread of its own without the interpreter's lock, while the caller's
//! thread looks for Ctrl-C and answers messages.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

use pyo3::prelude::*;
use supercoil::solve::Interrupt;

/// How often Ctrl-C is looked for.
const LOOK: Duration = Duration::from_millis(50);

/// Does `work`; every message it sends goes to `answer` on the caller's thread. Ctrl-C and an `Err` of `answer` raise
/// `interrupt`, and once the work has ended they are the result.
pub fn supervised<M: Send, R: Send>(
    py: Python,
    interrupt: &Interrupt,
    work: impl FnOnce(Sender<M>) -> R + Send,
    mut answer: impl FnMut(M) -> PyResult<()> + Send,
) -> PyResult<R> {
    py.detach(|| {
        let (sender, receiver) = channel();
        std::thread::scope(|scope| {
            let worker = scope.spawn(|| work(sender));
            let mut failed = None;
            loop {
                let seen = match receiver.recv_timeout(LOOK) {
                    Ok(message) => answer(message),
                    Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals()),
                    Err(RecvTimeoutError::Disconnected) => break,
                };
                if let Err(error) = seen {
                    interrupt.raise();
                    failed.get_or_insert(error);
                }
            }
            let result = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            interrupt.lower();
            failed.map_or(Ok(result), Err)
        })
    })
}
