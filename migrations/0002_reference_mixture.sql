-- The mixture of a reference is what a verdict compares with, so that damage and other settings must show. Rows of before
-- have NULL in both: their mixture is made anew from its view when it is next needed.

-- SHA-256 of the bytes of `mixture`, 64 lower-case hexadecimal digits.
ALTER TABLE reference ADD COLUMN mixture_sha256 TEXT;

-- What the mixture was made by, as JSON: the version of the fit and the settings that it depends on.
ALTER TABLE reference ADD COLUMN model TEXT;
