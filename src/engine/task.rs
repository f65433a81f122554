//! Small pieces of work that must not hold up the window, such as writing a file. Each has a thread of its own; all of
//! them end.

use super::OnUpdate;
use super::fault::{self, JobError};
use std::sync::{Arc, Mutex, PoisonError};

/// Identifies a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TaskId(u64);

/// What became of a task.
#[derive(Debug, Clone)]
pub struct TaskDone {
    /// Which.
    pub id: TaskId,
    /// What it does, as it was given.
    pub label: String,
    /// What it has to say, or why it failed.
    pub result: Result<String, JobError>,
}

#[derive(Default)]
struct Book {
    newest: u64,
    running: usize,
    done: Vec<TaskDone>,
}

pub(super) struct Tasks {
    book: Arc<Mutex<Book>>,
    on_update: OnUpdate,
}

impl Tasks {
    pub(super) fn new(on_update: OnUpdate) -> Self {
        Self { book: Arc::default(), on_update }
    }

    pub(super) fn start(
        &self,
        label: String,
        work: impl FnOnce() -> Result<String, String> + Send + 'static,
    ) -> TaskId {
        fault::install_hook();
        let id = {
            let mut book = lock(&self.book);
            book.newest += 1;
            book.running += 1;
            TaskId(book.newest)
        };
        let (book, on_update) = (self.book.clone(), self.on_update.clone());
        let key = format!("task-{}", std::ptr::from_ref(&*self.book) as usize + id.0 as usize);
        let name = format!("{}{key}", fault::THREAD_PREFIX);
        let run = move || {
            let result = fault::guard(&key, || work().map_err(JobError::Failed));
            let mut book = lock(&book);
            book.running -= 1;
            book.done.push(TaskDone { id, label, result });
            drop(book);
            on_update();
        };
        std::thread::Builder::new().name(name).spawn(run).expect("the system can start a handful of threads");
        id
    }

    pub(super) fn take_done(&self) -> Vec<TaskDone> {
        std::mem::take(&mut lock(&self.book).done)
    }

    pub(super) fn is_idle(&self) -> bool {
        lock(&self.book).running == 0
    }
}

fn lock(book: &Mutex<Book>) -> std::sync::MutexGuard<'_, Book> {
    book.lock().unwrap_or_else(PoisonError::into_inner)
}
