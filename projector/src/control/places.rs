//! Who may be connected: clients that were let in have places, and there is a waiting room for strangers.
//!
//! A stranger never holds a place. Where the waiting room is full one of those is sent away who came from the address
//! that most came from, the one who has been waiting longest: so who is let in at once comes through, however many
//! others knock. The next one may come when that one is gone: the connections that are open are bounded at any moment.

use std::{
    collections::{BTreeMap, VecDeque},
    net::IpAddr,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use tokio::sync::{Notify, OwnedSemaphorePermit, Semaphore};

/// Connections that may wait to be let in.
const MOST_STRANGERS: usize = 16;

/// The places, and the waiting room.
#[derive(Debug, Clone)]
pub(super) struct Places {
    free: Arc<Semaphore>,
    most: usize,
    waiting: Arc<Mutex<VecDeque<Waiting>>>,
    chairs: Arc<Semaphore>,
}

/// One in the waiting room; the oldest stands first.
#[derive(Debug)]
struct Waiting {
    number: u64,
    from: IpAddr,
    sent_away: Arc<Notify>,
}

/// Room for one more stranger; free again when it is dropped.
pub(super) type Chair = OwnedSemaphorePermit;

/// A connection that was not let in yet. Its end leaves the waiting room.
#[derive(Debug)]
pub(super) struct Stranger {
    places: Places,
    number: u64,
    sent_away: Arc<Notify>,
    chair: Mutex<Option<Chair>>,
}

/// The place of a client that was let in; free again when it is dropped.
pub(super) type Place = OwnedSemaphorePermit;

impl Places {
    /// So many places, all free.
    pub(super) fn new(most: usize) -> Self {
        Self {
            free: Arc::new(Semaphore::new(most)),
            most,
            waiting: Arc::default(),
            // one more than may wait, for the one who comes in while another leaves
            chairs: Arc::new(Semaphore::new(MOST_STRANGERS + 1)),
        }
    }

    /// Waits until one more stranger may come; nothing once no more are to come.
    pub(super) async fn chair(&self) -> Option<Chair> {
        self.chairs.clone().acquire_owned().await.ok()
    }

    /// Takes a connection into the waiting room; another one may have to leave it.
    pub(super) fn wait(&self, number: u64, from: IpAddr, chair: Chair) -> Stranger {
        let sent_away = Arc::new(Notify::new());
        let mut waiting = self.waiting();
        waiting.push_back(Waiting {
            number,
            from,
            sent_away: sent_away.clone(),
        });
        if waiting.len() > MOST_STRANGERS
            && let Some(leaves) = oldest_of_most(&waiting).and_then(|k| waiting.remove(k))
        {
            leaves.sent_away.notify_one();
        }
        drop(waiting);
        Stranger {
            places: self.clone(),
            number,
            sent_away,
            chair: Mutex::new(Some(chair)),
        }
    }

    fn waiting(&self) -> MutexGuard<'_, VecDeque<Waiting>> {
        locked(&self.waiting)
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Where the one stands who has been waiting longest of those from the address that most came from.
fn oldest_of_most(waiting: &VecDeque<Waiting>) -> Option<usize> {
    let mut from = BTreeMap::<IpAddr, (usize, usize)>::new();
    for (k, one) in waiting.iter().enumerate() {
        from.entry(one.from).or_insert((0, k)).0 += 1;
    }
    let most = from.into_values().max_by_key(|(count, _)| *count);
    most.map(|(_, oldest)| oldest)
}

impl Stranger {
    /// Waits until there is no room for this one any more.
    pub(super) async fn sent_away(&self) {
        self.sent_away.notified().await;
    }

    /// Gives a place to this one, who need not wait any more; nothing where none is free.
    pub(super) fn let_in(&self) -> Option<Place> {
        let place = self.places.free.clone().try_acquire_owned().ok()?;
        self.leave();
        Some(place)
    }

    /// How many places there are.
    pub(super) fn most(&self) -> usize {
        self.places.most
    }

    fn leave(&self) {
        self.places
            .waiting()
            .retain(|one| one.number != self.number);
        locked(&self.chair).take();
    }
}

impl Drop for Stranger {
    fn drop(&mut self) {
        self.leave();
    }
}

#[cfg(test)]
mod tests {
    use std::{future::Future, net::IpAddr};

    use super::{MOST_STRANGERS, Places, Stranger};

    const CROWD: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(10, 0, 0, 1));
    const OTHER: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(10, 0, 0, 2));

    /// What comes without waiting.
    async fn at_once<T>(future: impl Future<Output = T>) -> Option<T> {
        tokio::select! {
            biased;
            done = future => Some(done),
            () = std::future::ready(()) => None,
        }
    }

    async fn comes(places: &Places, number: u64, from: IpAddr) -> Stranger {
        let chair = at_once(places.chair()).await.flatten().unwrap();
        places.wait(number, from, chair)
    }

    /// Which of them have to leave; they go.
    async fn sent_away(strangers: &mut Vec<Stranger>) -> Vec<u64> {
        let mut gone = Vec::new();
        for stranger in std::mem::take(strangers) {
            match at_once(stranger.sent_away()).await {
                Some(()) => gone.push(stranger.number),
                None => strangers.push(stranger),
            }
        }
        gone
    }

    #[tokio::test]
    async fn the_oldest_of_the_crowd_leaves_and_nobody_else() {
        let places = Places::new(1);
        let mut other = vec![comes(&places, 1000, OTHER).await];
        let mut crowd = Vec::new();
        for k in 0..MOST_STRANGERS as u64 {
            crowd.push(comes(&places, k, CROWD).await);
        }
        assert!(at_once(places.chair()).await.is_none(), "one has to leave");
        assert_eq!(sent_away(&mut crowd).await, [0]);
        crowd.push(comes(&places, 100, CROWD).await);
        assert_eq!(sent_away(&mut crowd).await, [1]);
        assert_eq!(sent_away(&mut other).await, Vec::<u64>::new());
    }

    #[tokio::test]
    async fn who_is_let_in_need_not_leave_and_a_place_is_free_again_after_it() {
        let places = Places::new(1);
        let first = comes(&places, 1000, CROWD).await;
        let place = first.let_in().unwrap();
        let mut crowd = Vec::new();
        for k in 0..100 {
            crowd.push(comes(&places, k, CROWD).await);
            sent_away(&mut crowd).await;
        }
        assert_eq!(sent_away(&mut vec![first]).await, Vec::<u64>::new());
        let last = crowd.last().unwrap();
        assert!(last.let_in().is_none());
        drop(place);
        assert!(last.let_in().is_some());
    }

    #[tokio::test]
    async fn who_goes_by_himself_makes_room() {
        let places = Places::new(1);
        for round in 0..100 {
            let mut few = Vec::new();
            for number in [2 * round, 2 * round + 1] {
                few.push(comes(&places, number, CROWD).await);
            }
            assert_eq!(sent_away(&mut few).await, Vec::<u64>::new());
        }
    }
}
