-- The row of a sweep is written before its files, because an alarm does not wait for its evidence.

-- pending: the files are being written; missing: they could not be, evidence_why says why.
ALTER TABLE sweep ADD COLUMN evidence TEXT NOT NULL DEFAULT 'stored' CHECK (evidence IN ('pending', 'stored', 'missing'));
ALTER TABLE sweep ADD COLUMN evidence_why TEXT;

CREATE INDEX sweep_without_evidence ON sweep (id) WHERE evidence <> 'stored';

-- Rows that changed and are not in the journal (blobs/journal.txt) yet. Triggers, one set for each table, fill it
-- (src/store/journal_tables.rs).
CREATE TABLE unjournaled (
    id         INTEGER PRIMARY KEY AUTOINCREMENT,
    table_name TEXT NOT NULL,
    row_id     INTEGER NOT NULL
) STRICT;

-- One row where the journal knows changes that this database does not: it was lost, or set back.
CREATE TABLE journal_ahead (
    id      INTEGER PRIMARY KEY CHECK (id = 1),
    changes INTEGER NOT NULL
) STRICT;
