//! Activity of a computation of the command line: stages, as those of jobs.

/// A change of what is being worked on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Activity {
    /// A stage begins; where it works on several objects or tasks, with one of them.
    Began {
        stage: &'static str,
        instance: Option<String>,
    },
    Ended {
        stage: &'static str,
        instance: Option<String>,
    },
    /// Findings of a stage so far, in words.
    Found {
        stage: &'static str,
        message: String,
    },
}

/// Receives every change.
pub type Watch<'a> = &'a dyn Fn(Activity);

/// For computations without a watch.
pub fn unwatched(_: Activity) {}

/// Does a part of a stage.
pub fn staged<T>(watch: Watch, stage: &'static str, instance: Option<&str>, work: impl FnOnce() -> T) -> T {
    let instance = || instance.map(str::to_owned);
    watch(Activity::Began { stage, instance: instance() });
    let done = work();
    watch(Activity::Ended { stage, instance: instance() });
    done
}
