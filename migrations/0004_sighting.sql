-- One alarm is one thing. What each visit was to each alarm stands here: many visits see one thing, one visit many things.

CREATE TABLE sighting (
    id         INTEGER PRIMARY KEY AUTOINCREMENT,
    alarm_id   INTEGER NOT NULL REFERENCES alarm (id),
    visit_id   INTEGER NOT NULL REFERENCES visit (id),
    -- Position of the novelty among those of the visit; NULL where the thing was gone.
    position   INTEGER,
    relation   TEXT NOT NULL CHECK (relation IN ('raised', 'seen', 'moved', 'changed', 'gone', 'back')),
    -- From where the thing was, metres.
    distance_m REAL
) STRICT;

CREATE INDEX sighting_by_alarm ON sighting (alarm_id, id);
CREATE INDEX sighting_by_visit ON sighting (visit_id);

-- When a visit first could not see the alarm's place, since the last one that could; NULL if the last one could.
ALTER TABLE alarm ADD COLUMN unobserved_since TEXT;

-- Whose frame the positions of a reference are in, if not its own: the version that it was accepted or restored from.
ALTER TABLE reference ADD COLUMN frame_version INTEGER;

-- An alarm of before was all that one visit saw. A standing one keeps its number for the first novelty and gets new numbers for
-- the others, so that each clears by itself; a cleared one keeps all its things.
CREATE TABLE carried (alarm_id INTEGER NOT NULL, old_id INTEGER NOT NULL, position INTEGER NOT NULL) STRICT;

INSERT INTO carried (alarm_id, old_id, position)
SELECT a.id, a.id, n.position FROM alarm a JOIN novelty n ON n.visit_id = a.first_visit_id
WHERE a.state = 'cleared' OR n.position = (SELECT min(position) FROM novelty WHERE visit_id = a.first_visit_id);

INSERT INTO carried (alarm_id, old_id, position)
SELECT coalesce((SELECT seq FROM sqlite_sequence WHERE name = 'alarm'), 0) + row_number() OVER (ORDER BY a.id, n.position),
       a.id, n.position
FROM alarm a JOIN novelty n ON n.visit_id = a.first_visit_id
WHERE a.state <> 'cleared' AND n.position > (SELECT min(position) FROM novelty WHERE visit_id = a.first_visit_id);

INSERT INTO alarm (id, waypoint_id, raised_at, boot_id, first_visit_id, last_visit_id, last_seen_at, visits, state,
                   acknowledged_at, acknowledged_by, note)
SELECT c.alarm_id, a.waypoint_id, a.raised_at, a.boot_id, a.first_visit_id, a.last_visit_id, a.last_seen_at, a.visits, a.state,
       a.acknowledged_at, a.acknowledged_by, a.note
FROM carried c JOIN alarm a ON a.id = c.old_id WHERE c.alarm_id <> c.old_id;

INSERT INTO sighting (alarm_id, visit_id, position, relation)
SELECT c.alarm_id, a.first_visit_id, c.position, 'raised'
FROM carried c JOIN alarm a ON a.id = c.old_id ORDER BY a.first_visit_id, c.alarm_id, c.position;

-- A novelty of a later visit is the nearest of its kind.
INSERT INTO sighting (alarm_id, visit_id, position, relation)
SELECT coalesce((SELECT c.alarm_id FROM carried c JOIN novelty first ON first.visit_id = a.first_visit_id
                                                                    AND first.position = c.position
                 WHERE c.old_id = a.id AND first.kind = n.kind
                 ORDER BY (first.x_m - n.x_m) * (first.x_m - n.x_m) + (first.y_m - n.y_m) * (first.y_m - n.y_m)
                          + (first.z_m - n.z_m) * (first.z_m - n.z_m), c.position LIMIT 1), a.id),
       v.id, n.position, 'seen'
FROM alarm a JOIN visit v ON v.alarm_id = a.id AND v.id <> a.first_visit_id JOIN novelty n ON n.visit_id = v.id
ORDER BY v.id, n.position;

UPDATE alarm SET visits = (SELECT count(DISTINCT visit_id) FROM sighting WHERE alarm_id = alarm.id),
                 last_visit_id = (SELECT max(visit_id) FROM sighting WHERE alarm_id = alarm.id),
                 last_seen_at = (SELECT v.at FROM sighting s JOIN visit v ON v.id = s.visit_id
                                 WHERE s.alarm_id = alarm.id ORDER BY v.id DESC LIMIT 1)
WHERE id IN (SELECT c.alarm_id FROM carried c JOIN carried other ON other.old_id = c.old_id AND other.alarm_id <> c.alarm_id);

DROP TABLE carried;

-- What keeps the watch from seeing: devices, sweeps, the clock, waypoints that nobody visits. One standing row for each subject.
CREATE TABLE health (
    id         INTEGER PRIMARY KEY AUTOINCREMENT,
    subject    TEXT NOT NULL,
    reason     TEXT NOT NULL,
    since      TEXT NOT NULL,
    boot_id    TEXT NOT NULL,
    cleared_at TEXT
) STRICT;

CREATE UNIQUE INDEX health_standing ON health (subject) WHERE cleared_at IS NULL;
