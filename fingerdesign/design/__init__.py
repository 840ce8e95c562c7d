"""The design of a finger: one file a TOML table, the schema, keys, faults, digests."""
