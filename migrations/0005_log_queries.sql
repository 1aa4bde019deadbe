-- The log answers in milliseconds however long it is: each filter of `visits` and `events` has an index in the order in
-- which it is listed. What guards say about an alarm is kept beside it: the labels that thresholds are tuned by.

-- Newest by number.
CREATE INDEX visit_by_verdict ON visit (verdict);
CREATE INDEX visit_by_waypoint_verdict ON visit (waypoint_id, verdict);
-- Newest of a stretch of time.
CREATE INDEX visit_by_time ON visit (at);
CREATE INDEX visit_by_verdict_time ON visit (verdict, at);
CREATE INDEX visit_by_waypoint_time ON visit (waypoint_id, at);
CREATE INDEX visit_by_waypoint_verdict_time ON visit (waypoint_id, verdict, at);
-- Stamped by a clock that was not set yet: these match every stretch of time.
CREATE INDEX visit_of_unset_clock ON visit (id) WHERE at < '2026-01-01T00:00:00.000Z';

CREATE INDEX event_by_level ON event (level);
CREATE INDEX event_by_device ON event (device);
CREATE INDEX event_by_time ON event (at);
CREATE INDEX event_by_level_time ON event (level, at);
CREATE INDEX event_by_device_time ON event (device, at);
CREATE INDEX event_of_unset_clock ON event (id) WHERE at < '2026-01-01T00:00:00.000Z';

-- What filters of alarms ask of a novelty, without its record.
CREATE INDEX novelty_by_place ON novelty (visit_id, position, kind, x_m, y_m);
CREATE INDEX shape_by_novelty ON shape (novelty_id, class, size_x_m, size_y_m, size_z_m);

-- The newest answer counts; older ones stay.
CREATE TABLE alarm_answer (
    id          INTEGER PRIMARY KEY AUTOINCREMENT,
    alarm_id    INTEGER NOT NULL REFERENCES alarm (id),
    at          TEXT NOT NULL,
    boot_id     TEXT NOT NULL,
    answer      TEXT NOT NULL CHECK (answer IN ('confirmed', 'false_alarm')),
    answered_by TEXT NOT NULL
) STRICT;

CREATE INDEX alarm_answer_by_alarm ON alarm_answer (alarm_id, id);
