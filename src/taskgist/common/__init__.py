"""Common: what every room needs once: whole files, typed TOML tables, frozen values, processes, compiled functions."""
