//! The ticks of decorators.

use bt::{Kind, Status};

use super::object::{Context, Object};

impl Object {
    pub(super) fn tick_decorator(&mut self, context: &mut Context) -> Status {
        use Status::{Failure, Running, Skipped, Success};
        if let (Kind::RunOnce, Some(status)) = (self.kind, self.once) {
            return if self.numbers[0] > 0 { Skipped } else { status };
        }
        let is_active = self.status.is_some();
        self.status = Some(Running);
        match self.kind {
            Kind::SingleTrigger if is_active && self.triggered => return Failure,
            Kind::SingleTrigger => self.triggered = false,
            Kind::Repeat => return self.tick_again_after(Success, context),
            Kind::RetryUntilSuccessful => return self.tick_again_after(Failure, context),
            _ => {}
        }
        let status = self.children[0].execute_tick(context);
        if matches!(status, Success | Failure) {
            self.reset_children(context);
        }
        match (self.kind, status) {
            (Kind::KeepRunningUntilFailure, Success | Skipped) => Running,
            (Kind::Inverter, Success) | (Kind::ForceFailure, Success | Failure) => Failure,
            (Kind::Inverter, Failure) | (Kind::ForceSuccess, Success | Failure) => Success,
            (Kind::SingleTrigger, Success | Failure) => {
                self.triggered = true;
                status
            }
            (Kind::RunOnce, Success | Failure) => {
                self.once = Some(status);
                status
            }
            _ => status,
        }
    }

    /// Repeat after successes, and RetryUntilSuccessful after failures.
    fn tick_again_after(&mut self, counted: Status, context: &mut Context) -> Status {
        let most = self.numbers[0].abs();
        while self.cycles < most {
            let was_idle = self.children[0].status.is_none();
            let status = self.children[0].execute_tick(context);
            if status == Status::Running {
                return status;
            }
            self.reset_children(context);
            if status == Status::Skipped {
                return status;
            }
            if status != counted {
                self.cycles = 0;
                return status;
            }
            self.cycles += 1;
            if was_idle && self.cycles < most {
                context.woken = true;
                return Status::Running;
            }
        }
        self.cycles = 0;
        counted
    }
}
