-- The patrol's memory. Every table is ordered by its own sequence number (id), because the clock may be wrong;
-- boot_id says which run of the machine a row belongs to. Times are RFC 3339 in UTC. Positions are in the
-- waypoint's reference frame. Files are named by the SHA-256 of their content. A figure that is not finite is NULL.

-- "PTRD": whose database this is. Set together with the tables, so that no stop comes between the two.
PRAGMA application_id = 1347703364;

CREATE TABLE waypoint (
    id          INTEGER PRIMARY KEY AUTOINCREMENT,
    name        TEXT NOT NULL,
    created_at  TEXT NOT NULL,
    forgotten_at TEXT
) STRICT;

CREATE UNIQUE INDEX waypoint_by_name ON waypoint (name) WHERE forgotten_at IS NULL;

CREATE TABLE sweep (
    id          INTEGER PRIMARY KEY AUTOINCREMENT,
    waypoint_id INTEGER NOT NULL REFERENCES waypoint (id),
    taken_at    TEXT NOT NULL,
    boot_id     TEXT NOT NULL,
    points      INTEGER NOT NULL,
    view_file   TEXT,
    raw_file    TEXT,
    quality     TEXT NOT NULL
) STRICT;

CREATE INDEX sweep_by_waypoint ON sweep (waypoint_id, id);
CREATE INDEX sweep_by_view_file ON sweep (view_file);
CREATE INDEX sweep_by_raw_file ON sweep (raw_file);

CREATE TABLE reference (
    id          INTEGER PRIMARY KEY AUTOINCREMENT,
    waypoint_id INTEGER NOT NULL REFERENCES waypoint (id),
    version     INTEGER NOT NULL,
    sweep_id    INTEGER NOT NULL REFERENCES sweep (id),
    taken_at    TEXT NOT NULL,
    boot_id     TEXT NOT NULL,
    components  INTEGER NOT NULL,
    seed        INTEGER NOT NULL,
    engine      TEXT NOT NULL,
    mixture     BLOB NOT NULL,
    UNIQUE (waypoint_id, version)
) STRICT;

CREATE INDEX reference_by_sweep ON reference (sweep_id);

CREATE TABLE visit (
    id           INTEGER PRIMARY KEY AUTOINCREMENT,
    waypoint_id  INTEGER NOT NULL REFERENCES waypoint (id),
    reference_id INTEGER REFERENCES reference (id),
    sweep_id     INTEGER REFERENCES sweep (id),
    alarm_id     INTEGER REFERENCES alarm (id),
    at           TEXT NOT NULL,
    boot_id      TEXT NOT NULL,
    verdict      TEXT NOT NULL CHECK (verdict IN ('quiet', 'changed', 'not_observed')),
    reason       TEXT NOT NULL,
    d_gmm        REAL,
    u_th         REAL,
    seed         INTEGER NOT NULL,
    engine       TEXT NOT NULL,
    report       TEXT NOT NULL
) STRICT;

CREATE INDEX visit_by_waypoint ON visit (waypoint_id, id);
CREATE INDEX visit_by_sweep ON visit (sweep_id);
CREATE INDEX visit_by_reference ON visit (reference_id);
CREATE INDEX visit_by_alarm ON visit (alarm_id);

CREATE TABLE alarm (
    id              INTEGER PRIMARY KEY AUTOINCREMENT,
    waypoint_id     INTEGER NOT NULL REFERENCES waypoint (id),
    raised_at       TEXT NOT NULL,
    boot_id         TEXT NOT NULL,
    first_visit_id  INTEGER NOT NULL REFERENCES visit (id),
    last_visit_id   INTEGER NOT NULL REFERENCES visit (id),
    last_seen_at    TEXT NOT NULL,
    visits          INTEGER NOT NULL DEFAULT 1,
    state           TEXT NOT NULL CHECK (state IN ('open', 'acknowledged', 'cleared')),
    acknowledged_at TEXT,
    acknowledged_by TEXT,
    note            TEXT,
    cleared_at      TEXT,
    cleared_because TEXT
) STRICT;

CREATE INDEX alarm_by_waypoint ON alarm (waypoint_id, state, id);
CREATE INDEX alarm_by_time ON alarm (raised_at);

CREATE TABLE novelty (
    id           INTEGER PRIMARY KEY AUTOINCREMENT,
    visit_id     INTEGER NOT NULL REFERENCES visit (id),
    position     INTEGER NOT NULL,
    kind         TEXT NOT NULL CHECK (kind IN ('appeared', 'disappeared')),
    x_m          REAL,
    y_m          REAL,
    z_m          REAL,
    points       INTEGER NOT NULL,
    mass         REAL,
    contribution REAL,
    record       TEXT NOT NULL,
    UNIQUE (visit_id, position)
) STRICT;

CREATE TABLE shape (
    id          INTEGER PRIMARY KEY AUTOINCREMENT,
    novelty_id  INTEGER NOT NULL UNIQUE REFERENCES novelty (id),
    class       TEXT NOT NULL,
    method      TEXT NOT NULL,
    probability REAL,
    size_x_m    REAL,
    size_y_m    REAL,
    size_z_m    REAL
) STRICT;

CREATE TABLE event (
    id      INTEGER PRIMARY KEY AUTOINCREMENT,
    at      TEXT NOT NULL,
    boot_id TEXT NOT NULL,
    level   TEXT NOT NULL CHECK (level IN ('info', 'warning', 'error')),
    device  TEXT NOT NULL,
    text    TEXT NOT NULL
) STRICT;
