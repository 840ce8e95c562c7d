"""What a finger is: one file a TOML table, the schema, keys, faults, digests."""
