//! Ctrl-C.

use supercoil::solve::Interrupt;

use super::INTERRUPTED;

/// Raises `interrupt` at Ctrl-C or a request to terminate; the second one ends the program at once.
pub fn stop_on_signal(interrupt: Interrupt, note: impl Fn(&str) + Send + 'static) {
    // without a handler Ctrl-C still ends the program, but without outputs
    ctrlc::set_handler(move || {
        if interrupt.is_raised() {
            std::process::exit(i32::from(INTERRUPTED));
        }
        interrupt.raise();
        note("stopping; once more to end at once");
    })
    .ok();
}
