//! The thread that owns the robot: its calls block, so they have a thread of their own, and a bound each.

use super::constants::{
    BACK_LIMIT, LEG_LIMIT, LINE_LIMIT, OPEN_LIMIT, RECOVERY_LIMIT, TILT_SLACK, WATCH_PACE,
};
use super::robot::{Away, Connect, Fault, Notes, Robot};
use crate::config::{Settings, SweepMode};
use crate::devices::Cancel;
use link::Clock;
use patrold_engine::sweep::RawSweep;
use serde_json::Value;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// What the thread tells.
#[derive(Debug)]
pub enum RobotEvent {
    /// Connected and homed; who answers.
    Ready(Value),
    /// Not connected.
    Failed(String),
    /// Not connected, for a device is not there.
    Absent(String),
    /// Gone while nothing was asked of them.
    Lost(String),
    /// Let go.
    Closed,
    /// A sweep, for the request of that number.
    Swept(u64, Box<RawSweep>),
    /// The head is back where the last sweep began, after so long on the devices' clock; `None`: it stayed somewhere.
    Returned(Option<Duration>),
    /// No sweep, for the request of that number.
    SweepFailed(u64, Fault),
}

enum Order {
    Open(Arc<Settings>, Cancel),
    Sweep(u64, Arc<Settings>, Option<String>, Cancel),
    Distrust,
    Close,
}

type Bound = Arc<Mutex<Option<Instant>>>;

/// Handle of the thread.
pub struct RobotThread {
    orders: Sender<Order>,
    clock: Clock,
    cancel: Cancel,
    /// Of the last sweep: after it the head goes back, though something else was ordered since.
    swept: Cancel,
    bound: Bound,
}

impl RobotThread {
    /// Starts the thread; every event goes through `tell`.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn spawn(
        connect: Box<dyn Connect>,
        clock: Clock,
        notes: Notes,
        tell: impl FnMut(RobotEvent) + Send + 'static,
    ) -> std::io::Result<Self> {
        let (orders, inbox) = mpsc::channel();
        let bound = Bound::default();
        let owner = Owner {
            connect,
            notes,
            clock: clock.clone(),
            robot: None,
            settings: None,
            bound: Arc::clone(&bound),
            tell,
        };
        thread::Builder::new()
            .name("patrold-robot".to_owned())
            .spawn(move || owner.run(&inbox))?;
        Ok(Self {
            orders,
            clock,
            cancel: Cancel::new(),
            swept: Cancel::new(),
            bound,
        })
    }

    /// Lets the devices go if they are open, connects and homes them.
    pub fn open(&mut self, settings: Arc<Settings>) {
        self.cancel = Cancel::new();
        self.send(Order::Open(settings, self.cancel.clone()));
    }

    /// Takes a sweep.
    pub fn sweep(&mut self, id: u64, settings: Arc<Settings>, waypoint: Option<String>) {
        self.cancel = Cancel::new();
        self.swept = self.cancel.clone();
        self.send(Order::Sweep(id, settings, waypoint, self.cancel.clone()));
    }

    /// Takes the head's angles for worthless, until it is homed before the next sweep.
    pub fn distrust(&self) {
        self.send(Order::Distrust);
    }

    /// Interrupts what was last ordered, and the way back from a sweep.
    pub fn cancel(&self) {
        self.cancel.cancel();
        self.swept.cancel();
    }

    /// Lets the devices go.
    pub fn close(&self) {
        self.send(Order::Close);
    }

    /// Whether a call takes longer than any honest one.
    pub fn is_overdue(&self) -> bool {
        lock(&self.bound).is_some_and(|until| Instant::now() > until)
    }

    /// The clock of the devices.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    fn send(&self, order: Order) {
        // The thread lives as long as this handle.
        let _ = self.orders.send(order);
    }
}

fn lock(bound: &Bound) -> std::sync::MutexGuard<'_, Option<Instant>> {
    bound.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Owner<F> {
    connect: Box<dyn Connect>,
    notes: Notes,
    clock: Clock,
    robot: Option<Box<dyn Robot>>,
    /// Settings that the robot was connected under.
    settings: Option<Arc<Settings>>,
    bound: Bound,
    tell: F,
}

impl<F: FnMut(RobotEvent)> Owner<F> {
    fn run(mut self, inbox: &Receiver<Order>) {
        loop {
            let order = match inbox.recv_timeout(WATCH_PACE) {
                Ok(order) => Some(order),
                Err(RecvTimeoutError::Timeout) => None,
                Err(RecvTimeoutError::Disconnected) => return,
            };
            let event = match order {
                None => self.watch(),
                Some(order) => self.obey(order),
            };
            if let Some(event) = event {
                (self.tell)(event);
            }
        }
    }

    fn obey(&mut self, order: Order) -> Option<RobotEvent> {
        match order {
            Order::Open(settings, cancel) => self.open(settings, &cancel),
            Order::Sweep(id, settings, waypoint, cancel) => {
                let event = self.sweep(id, &settings, waypoint.as_deref(), &cancel);
                let swept = matches!(event, RobotEvent::Swept(..));
                // Whoever judges it begins now.
                (self.tell)(event);
                if !swept {
                    return None;
                }
                let back = self.go_back(&cancel);
                (self.tell)(RobotEvent::Returned(back));
                // What was lost on the way is known now.
                self.watch()
            }
            Order::Distrust => {
                self.robot.as_mut()?.distrust();
                None
            }
            Order::Close => {
                self.robot = None;
                Some(RobotEvent::Closed)
            }
        }
    }

    /// Lost devices are told of: whoever hears of it has them resumed or opened anew.
    fn watch(&mut self) -> Option<RobotEvent> {
        let fault = self.robot.as_mut()?.watch().err().filter(|f| f.lost)?;
        Some(RobotEvent::Lost(fault.reason))
    }

    /// An opening that was cancelled tells nothing: whoever cancelled it ordered something else.
    fn open(&mut self, settings: Arc<Settings>, cancel: &Cancel) -> Option<RobotEvent> {
        self.begin(OPEN_LIMIT);
        let event = match self.resume_or_connect(settings, cancel) {
            Ok(who) => RobotEvent::Ready(who),
            Err(Away { reason, absent }) if absent => RobotEvent::Absent(reason),
            Err(Away { reason, .. }) => RobotEvent::Failed(reason),
        };
        self.end();
        (!cancel.is_cancelled()).then_some(event)
    }

    /// A robot that lost one device keeps the other, and what is known of it.
    fn resume_or_connect(
        &mut self,
        settings: Arc<Settings>,
        cancel: &Cancel,
    ) -> Result<Value, Away> {
        let same = |old: &Arc<Settings>| old.laser == settings.laser && old.ptu == settings.ptu;
        if let Some(robot) = self
            .robot
            .as_mut()
            .filter(|_| self.settings.as_ref().is_some_and(same))
        {
            match robot.resume(cancel) {
                Ok(()) => return Ok(robot.describe()),
                Err(away) if away.absent || cancel.is_cancelled() => return Err(away),
                Err(_) => {}
            }
        }
        self.robot = None;
        let mut robot = self.connect.connect(&settings, &self.notes, cancel)?;
        let who = robot.describe();
        (self.robot, self.settings) = (Some(robot), Some(settings));
        Ok(who)
    }

    fn sweep(
        &mut self,
        id: u64,
        settings: &Settings,
        waypoint: Option<&str>,
        cancel: &Cancel,
    ) -> RobotEvent {
        self.begin(longest_sweep(settings, waypoint));
        let taken = match &mut self.robot {
            Some(robot) => robot.sweep(settings, waypoint, cancel),
            None => Err(Fault {
                reason: "the devices are not open".to_owned(),
                lost: true,
            }),
        };
        self.end();
        match taken {
            Ok(raw) => RobotEvent::Swept(id, Box::new(raw)),
            Err(fault) => RobotEvent::SweepFailed(id, fault),
        }
    }

    fn go_back(&mut self, cancel: &Cancel) -> Option<Duration> {
        self.begin(BACK_LIMIT);
        let took = self.robot.as_mut().and_then(|robot| robot.go_back(cancel));
        self.end();
        took
    }

    fn begin(&self, limit: Duration) {
        *lock(&self.bound) = Some(Instant::now() + self.clock.wall(limit));
    }

    fn end(&self) {
        *lock(&self.bound) = None;
    }
}

/// Longest honest sweep, of the devices' clock.
pub(super) fn longest_sweep(settings: &Settings, waypoint: Option<&str>) -> Duration {
    let sweep = &settings.sweep;
    let legs = match waypoint {
        Some(name) => settings.pans_rad(name).len(),
        None => sweep.pans_rad.len(),
    };
    let span_rad = (sweep.tilt_to_rad - sweep.tilt_from_rad).abs();
    let leg = match sweep.mode {
        SweepMode::Continuous => {
            Duration::try_from_secs_f64(TILT_SLACK * span_rad / sweep.speed_rad_s)
        }
        SweepMode::Step => Duration::try_from_secs_f64(
            LINE_LIMIT.as_secs_f64() * (span_rad / sweep.step_rad + 1.0),
        ),
    };
    let leg = leg.unwrap_or(Duration::ZERO) + LEG_LIMIT;
    RECOVERY_LIMIT + leg * u32::try_from(legs).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::{RobotEvent, RobotThread, longest_sweep};
    use crate::config::{Settings, SweepMode};
    use crate::devices::Cancel;
    use crate::service::robot::{Away, Connect, Fault, Notes, Robot};
    use link::Clock;
    use patrold_engine::sweep::RawSweep;
    use serde_json::Value;
    use std::sync::{Arc, Mutex, mpsc};
    use std::thread;
    use std::time::Duration;

    /// A robot whose sweep hangs in a read until the sender of this is gone.
    struct Hangs(Arc<Mutex<mpsc::Receiver<()>>>);

    impl Connect for Hangs {
        fn connect(&mut self, _: &Settings, _: &Notes, _: &Cancel) -> Result<Box<dyn Robot>, Away> {
            Ok(Box::new(Self(Arc::clone(&self.0))))
        }
    }

    impl Robot for Hangs {
        fn describe(&mut self) -> Value {
            Value::Null
        }

        fn sweep(&mut self, _: &Settings, _: Option<&str>, _: &Cancel) -> Result<RawSweep, Fault> {
            // Ends with an error when the sender goes.
            let _ = self.0.lock().expect("one thread").recv();
            Err(Fault {
                reason: "the read came back".to_owned(),
                lost: true,
            })
        }
    }

    #[test]
    fn a_call_that_hangs_in_a_read_is_overdue_and_no_more_once_it_came_back() {
        let (held, hangs) = mpsc::channel();
        let (tell, told) = mpsc::channel();
        let mut robot = RobotThread::spawn(
            Box::new(Hangs(Arc::new(Mutex::new(hangs)))),
            Clock::scaled(1e4),
            Notes::new(|_, _, _| ()),
            move |event| drop(tell.send(event)),
        )
        .expect("a thread");
        let settings = Arc::new(Settings::defaults());
        robot.open(Arc::clone(&settings));
        let ready = told.recv().expect("it lives");
        assert!(matches!(ready, RobotEvent::Ready(_)), "{ready:?}");
        assert!(!robot.is_overdue());
        robot.sweep(1, settings, None);
        while !robot.is_overdue() {
            thread::sleep(Duration::from_millis(1));
        }
        // Cancelling does not reach it: the watchdog starves, and systemd starts the service anew.
        robot.cancel();
        assert!(robot.is_overdue());
        drop(held);
        let ended = told.recv().expect("it lives");
        assert!(matches!(ended, RobotEvent::SweepFailed(1, _)), "{ended:?}");
        assert!(!robot.is_overdue());
    }

    #[test]
    fn the_bound_of_a_sweep_grows_with_its_legs_and_lines() {
        let mut settings = Settings::defaults();
        // 60 deg at 5 deg/s, twice, and a minute; before it a minute and a half of homing.
        assert_eq!(longest_sweep(&settings, None).as_secs(), 174);
        settings.sweep.pans_rad = vec![0.0, 1.0];
        assert_eq!(longest_sweep(&settings, Some("hall")).as_secs(), 258);
        settings.sweep.mode = SweepMode::Step;
        assert!(longest_sweep(&settings, None) > Duration::from_secs(360));
    }
}
