//! Requests to measure: the latest scan once, or scans from now on (protocol section 6).

use super::Instant;
use super::commands::Answer;
use super::engine::Twin;
use super::request::{Request, decimal};
use super::scanning::Window;
use super::state::{Status, Stream};
use super::surroundings::Surroundings;

impl Twin {
    fn window(&self, request: &Request) -> Result<Window, Status> {
        let max_step = self.options.profile.max_step;
        Window::parse(request.parameters(), request.coding(), max_step)
    }

    /// What forbids measuring at `t`.
    fn cannot_measure(&self, t: Instant) -> Option<Status> {
        let malfunction = self.state.malfunction_at(t);
        malfunction
            .map(|malfunction| Status::number(malfunction.status))
            .or(self.state.asleep.then_some(Status::DENIED))
    }

    /// `GD` and its like: the latest complete scan.
    pub(super) fn latest(
        &mut self,
        request: &Request,
        t: Instant,
        surroundings: &mut dyn Surroundings,
    ) -> Result<Answer, Status> {
        let window = self.window(request)?;
        if let Some(status) = self.cannot_measure(t) {
            return Err(status);
        }
        if !self.state.laser {
            return Err(Status::LASER_OFF);
        }
        let under_way = self.motor.revolution_at(t);
        let last_step = u64::from(self.options.profile.max_step);
        let latest = if self.motor.step_of(under_way, last_step) <= t {
            under_way
        } else {
            under_way.saturating_sub(1)
        };
        let min_range_mm = self.options.profile.min_range_mm;
        let mut lines = Vec::new();
        let scan = self.measure(latest, t, surroundings);
        window.push_scan(&mut lines, scan, min_range_mm);
        Ok(Answer::Scan(lines))
    }

    /// `MD` and its like.
    pub(super) fn start_stream(&mut self, request: &Request, t: Instant) -> Result<Status, Status> {
        let parameters = request.parameters();
        let window = self.window(request)?;
        let number = |from: usize, to: usize, status: u8| {
            parameters
                .get(from..to)
                .and_then(decimal)
                .ok_or(Status::number(status))
        };
        let interval = number(10, 11, 6)?;
        let count = number(11, 13, 7)?;
        if let Some(status) = self.cannot_measure(t) {
            return Err(status);
        }
        if self.state.stream.is_some() {
            return Err(Status::BUFFER_SHORTAGE);
        }
        self.state.laser = true;
        self.state.stream = Some(Stream {
            head: request.body().get(..13).unwrap_or_default().to_vec(),
            tail: request.tail().to_vec(),
            window,
            interval: u64::from(interval),
            count,
            sent: 0,
            next_revolution: self.motor.revolution_at(t) + 1,
            pause: None,
        });
        Ok(Status::DONE)
    }
}
