"""The finger's description: schema, TOML in and out, layout, checks and digest."""
