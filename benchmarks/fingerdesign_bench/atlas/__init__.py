"""The atlas of verified fingers, from candidates.toml."""
