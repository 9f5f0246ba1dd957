CREATE TABLE meta (
    key TEXT PRIMARY KEY,
    value TEXT NOT NULL
) WITHOUT ROWID;
CREATE TABLE evaluation (
    id INTEGER PRIMARY KEY,      -- index in the run, from 0
    generation INTEGER NOT NULL,
    population TEXT NOT NULL,    -- the target that its population works for
    parents TEXT NOT NULL,       -- JSON array of evaluation ids
    grammar TEXT NOT NULL,
    symbols TEXT NOT NULL,       -- JSON array of strings
    tuning REAL NOT NULL,        -- of the body, in the unit of its builder
    seed INTEGER NOT NULL,       -- of what was random about it, see scenario.evaluation_seed()
    failure TEXT,
    ended TEXT,
    duration REAL,               -- of the flight, s
    contact REAL,                -- when it first touched a wall, s
    energy_drift REAL,           -- up to then, relative
    error REAL,                  -- estimated, of the position, m
    seconds REAL NOT NULL,       -- that the evaluation took
    trajectory BLOB              -- see driftform.runs.compression.encode
);
CREATE TABLE score (
    evaluation INTEGER NOT NULL REFERENCES evaluation (id),
    target TEXT NOT NULL,
    fitness REAL NOT NULL,
    PRIMARY KEY (target, evaluation)
) WITHOUT ROWID;
CREATE TABLE measured (
    evaluation INTEGER PRIMARY KEY REFERENCES evaluation (id),
    found TEXT NOT NULL          -- JSON: measures and violations by name
);
CREATE TABLE disturbed (
    evaluation INTEGER NOT NULL REFERENCES evaluation (id),
    condition INTEGER NOT NULL,  -- number of the disturbed condition, see Pipeline.conditions
    target TEXT NOT NULL,
    fitness REAL NOT NULL,
    x REAL,                      -- from the target to the closest approach, m; NULL for a failed flight
    y REAL,
    z REAL,
    failure TEXT,
    PRIMARY KEY (target, evaluation, condition)
) WITHOUT ROWID;
