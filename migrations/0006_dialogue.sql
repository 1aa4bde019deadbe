-- The bytes of both devices of a visit's sweep, as they came (docs/recording.md), beside its view and its raw data.

ALTER TABLE sweep ADD COLUMN dialogue_file TEXT;
-- Why they are not there. Without a file and a reason: taken by a patrold that did not keep them.
ALTER TABLE sweep ADD COLUMN dialogue_why TEXT;

CREATE INDEX sweep_by_dialogue_file ON sweep (dialogue_file) WHERE dialogue_file IS NOT NULL;
