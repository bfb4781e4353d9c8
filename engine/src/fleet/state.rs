//! What the members of a fleet share: who renders what, what has been gathered, who is gone.

use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::film::Film;
use crate::stats::Stats;

use super::queue::{Pace, Queue, joined, portion};

/// What a member does next.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Renders these paths.
    Render(Range<u64>),
    /// Hands over what its device has gathered.
    Collect,
    /// There is nothing left to do, and never will be.
    End,
}

/// Where a member is in its life.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Phase {
    /// Its device is being made ready.
    Preparing,
    /// It renders, or waits for something to render.
    Working,
    /// It is gone.
    Ended,
}

/// A device as the others see it.
#[derive(Debug)]
pub(super) struct Member {
    pub(super) phase: Phase,
    pace: Pace,
    /// What it is rendering.
    held: Option<Range<u64>>,
    /// How far it is in that.
    at: u64,
    /// What lies in the film on its device.
    gathered: Vec<Range<u64>>,
    /// What lies in the common film.
    pub(super) collected: Vec<Range<u64>>,
    /// Ranges that it has taken.
    pub(super) ranges: u64,
    /// Time spent in rendering.
    pub(super) took: Duration,
    /// As they were when its film was collected last.
    pub(super) stats: Option<Stats>,
    /// Why it is gone, if it shouldn't be.
    pub(super) failure: Option<String>,
}

impl Member {
    pub(super) fn new(first: u64) -> Self {
        Self {
            phase: Phase::Preparing,
            pace: Pace { rate: None, first },
            held: None,
            at: 0,
            gathered: Vec::new(),
            collected: Vec::new(),
            ranges: 0,
            took: Duration::ZERO,
            stats: None,
            failure: None,
        }
    }

    /// What it has rendered and isn't lost.
    fn rendered(&self) -> impl Iterator<Item = Range<u64>> {
        let held = self.held.iter().map(|held| held.start..self.at);
        let others = self.gathered.iter().chain(&self.collected);
        held.chain(others.cloned())
    }

    /// So many paths.
    pub(super) fn paths(&self) -> u64 {
        self.rendered().map(|range| range.end - range.start).sum()
    }
}

/// All of it, behind one lock.
#[derive(Debug)]
pub(super) struct State {
    pub(super) queue: Queue,
    pub(super) members: Vec<Member>,
    pub(super) is_stopped: bool,
    /// Failures that have not been told yet, by member.
    pub(super) news: Vec<usize>,
    /// When the first device was ready.
    pub(super) ready_at: Option<Duration>,
}

impl State {
    /// Paths that are rendered.
    pub(super) fn done(&self) -> u64 {
        self.members.iter().map(Member::paths).sum()
    }

    /// Of the first paths, up to this one, those that are rendered.
    pub(super) fn done_below(&self, end: u64) -> u64 {
        let rendered = self.members.iter().flat_map(Member::rendered);
        rendered
            .map(|range| range.end.min(end).saturating_sub(range.start))
            .sum()
    }

    /// Nothing is free, and nobody has anything that he could lose.
    pub(super) fn is_settled(&self) -> bool {
        let has_nothing = |member: &Member| member.held.is_none() && member.gathered.is_empty();
        (self.is_stopped || self.queue.left() == 0) && self.members.iter().all(has_nothing)
    }

    /// Nobody is left who could do anything.
    pub(super) fn is_deserted(&self) -> bool {
        self.members
            .iter()
            .all(|member| member.phase == Phase::Ended)
    }

    /// The next range of a member.
    fn take(&mut self, own: usize) -> Option<Range<u64>> {
        let left = self.queue.left();
        if left == 0 {
            return None;
        }
        let places = (0..self.members.len()).filter(|&i| self.members[i].phase == Phase::Working);
        let places: Vec<usize> = places.collect();
        let paces: Vec<Pace> = places.iter().map(|&i| self.members[i].pace).collect();
        let among = places.iter().position(|&i| i == own)?;
        let range = self.queue.take(portion(left, &paces, among)?)?;
        let member = &mut self.members[own];
        member.at = range.start;
        member.held = Some(range.clone());
        member.ranges += 1;
        Some(range)
    }

    /// What a member had and nobody has collected is to be rendered by others.
    fn give_back(&mut self, own: usize) {
        let member = &mut self.members[own];
        let lost = member.gathered.drain(..).chain(member.held.take());
        for range in lost.collect::<Vec<_>>() {
            self.queue.give_back(range);
        }
    }
}

/// What the members share. The film has a lock of its own: adding to it takes a while.
#[derive(Debug)]
pub(super) struct Shared {
    state: Mutex<State>,
    /// Notified when there may be something to do, or to be told.
    changed: Condvar,
    film: Mutex<Option<Film>>,
}

impl Shared {
    pub(super) fn new(queue: Queue, members: Vec<Member>) -> Self {
        Self {
            state: Mutex::new(State {
                queue,
                members,
                is_stopped: false,
                news: Vec::new(),
                ready_at: None,
            }),
            changed: Condvar::new(),
            film: Mutex::new(None),
        }
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Changes the state, and wakes all who wait.
    pub(super) fn change<T>(&self, change: impl FnOnce(&mut State) -> T) -> T {
        let result = change(&mut self.lock());
        self.changed.notify_all();
        result
    }

    /// Waits until something has changed, or for so long.
    pub(super) fn wait<'a>(
        &self,
        state: MutexGuard<'a, State>,
        most: Duration,
    ) -> MutexGuard<'a, State> {
        let waited = self.changed.wait_timeout(state, most);
        waited.unwrap_or_else(PoisonError::into_inner).0
    }

    /// Waits until something is so.
    pub(super) fn wait_until(&self, is_so: impl Fn(&State) -> bool) -> MutexGuard<'_, State> {
        let waited = self.changed.wait_while(self.lock(), |state| !is_so(state));
        waited.unwrap_or_else(PoisonError::into_inner)
    }

    /// A member's device is ready, at this time.
    pub(super) fn is_ready(&self, own: usize, now: Duration) {
        self.change(|state| {
            state.members[own].phase = Phase::Working;
            state.ready_at.get_or_insert(now);
        });
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.lock().is_stopped
    }

    /// What a member does next. Waits where there is nothing to do, but another member may fail.
    pub(super) fn next(&self, own: usize) -> Next {
        let mut state = self.lock();
        loop {
            if !state.is_stopped
                && let Some(range) = state.take(own)
            {
                return Next::Render(range);
            }
            if !state.members[own].gathered.is_empty() {
                return Next::Collect;
            }
            if state.is_stopped || state.is_settled() {
                return Next::End;
            }
            let waited = self.changed.wait(state);
            state = waited.unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// A member has come so far in its range.
    pub(super) fn reached(&self, own: usize, at: u64) {
        self.change(|state| state.members[own].at = at);
    }

    /// A member has done its range, or as much of it as was wanted.
    pub(super) fn rendered(&self, own: usize, took: Duration) {
        self.change(|state| {
            let member = &mut state.members[own];
            let Some(held) = member.held.take() else {
                return;
            };
            let (done, rest) = (held.start..member.at, member.at..held.end);
            let rate = (done.end - done.start) as f64 / took.as_secs_f64().max(1e-6);
            // The speed differs from one part of the picture to another.
            let before = member.pace.rate.unwrap_or(rate);
            member.pace.rate = Some(0.5 * (before + rate));
            member.took += took;
            if !done.is_empty() {
                member.gathered.push(done);
            }
            state.queue.give_back(rest);
        });
    }

    /// A member hands over what its device had gathered.
    pub(super) fn collected(&self, own: usize, film: Film, stats: Stats) {
        {
            let mut common = self.film.lock().unwrap_or_else(PoisonError::into_inner);
            match &mut *common {
                Some(common) => common.add(&film),
                None => *common = Some(film),
            }
        }
        self.change(|state| {
            let member = &mut state.members[own];
            let mut all = std::mem::take(&mut member.collected);
            all.append(&mut member.gathered);
            member.collected = joined(all);
            member.stats = Some(stats);
        });
    }

    /// A member is gone; if by a failure, what it had is handed back.
    pub(super) fn ended(&self, own: usize, failure: Option<String>) {
        self.change(|state| {
            state.give_back(own);
            let member = &mut state.members[own];
            member.phase = Phase::Ended;
            member.failure = failure;
            if member.failure.is_some() {
                state.news.push(own);
            }
        });
    }

    /// Looks at what has been collected.
    pub(super) fn with_film<T>(&self, look: impl FnOnce(&Film) -> T) -> Option<T> {
        let film = self.film.lock().unwrap_or_else(PoisonError::into_inner);
        film.as_ref().map(look)
    }

    /// What has been collected; nothing is left here then.
    pub(super) fn take_film(&self) -> Option<Film> {
        let mut film = self.film.lock().unwrap_or_else(PoisonError::into_inner);
        film.take()
    }
}
