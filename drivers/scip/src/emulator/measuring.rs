//! Requests to measure: the latest scan, or a stream (scip2 section 6).

use super::commands::CommandReply;
use super::emulated_laser::EmulatedLaser;
use super::range_source::RangeSource;
use super::request::RequestLine;
use super::state::ActiveStream;
use super::status::ReplyStatus;
use super::window::StepWindow;
use super::wire::decimal;
use std::time::Duration;

impl EmulatedLaser {
    fn window(&self, request: &RequestLine) -> Result<StepWindow, ReplyStatus> {
        let max_step = self.options.profile.max_step;
        StepWindow::parse(request.parameters(), request.coding(), max_step)
    }

    /// The status if measuring is impossible at `t`.
    fn cannot_measure(&self, t: Duration) -> Option<ReplyStatus> {
        let malfunction = self.state.malfunction_at(t);
        malfunction
            .map(|malfunction| ReplyStatus::number(malfunction.status))
            .or(self.state.asleep.then_some(ReplyStatus::DENIED))
    }

    /// `GD` and its relatives: the latest complete scan.
    pub(super) fn latest(
        &mut self,
        request: &RequestLine,
        t: Duration,
        source: &mut dyn RangeSource,
    ) -> Result<CommandReply, ReplyStatus> {
        let window = self.window(request)?;
        if let Some(status) = self.cannot_measure(t) {
            return Err(status);
        }
        if !self.state.laser_on {
            return Err(ReplyStatus::LASER_OFF);
        }
        let current = self.motor.revolution_at(t);
        let last_step = u64::from(self.options.profile.max_step);
        let latest = if self.motor.step_time(current, last_step) <= t {
            current
        } else {
            current.saturating_sub(1)
        };
        let min_range_mm = self.options.profile.min_range_mm;
        let mut lines = Vec::new();
        let scan = self.measure(latest, t, source);
        window.push_scan(&mut lines, scan, min_range_mm);
        Ok(CommandReply::Scan(lines))
    }

    /// `MD` and its relatives.
    pub(super) fn start_stream(
        &mut self,
        request: &RequestLine,
        t: Duration,
    ) -> Result<ReplyStatus, ReplyStatus> {
        let parameters = request.parameters();
        let window = self.window(request)?;
        let number = |from: usize, to: usize, status: u8| {
            parameters
                .get(from..to)
                .and_then(decimal)
                .ok_or(ReplyStatus::number(status))
        };
        let interval = number(10, 11, 6)?;
        let count = number(11, 13, 7)?;
        if let Some(status) = self.cannot_measure(t) {
            return Err(status);
        }
        if self.state.stream.is_some() {
            return Err(ReplyStatus::BUFFER_SHORTAGE);
        }
        self.state.laser_on = true;
        self.state.stream = Some(ActiveStream {
            head: request.body().get(..13).unwrap_or_default().to_vec(),
            tail: request.tail().to_vec(),
            window,
            interval: u64::from(interval),
            count,
            sent: 0,
            next_revolution: self.motor.revolution_at(t) + 1,
            pause: None,
        });
        Ok(ReplyStatus::DONE)
    }
}
